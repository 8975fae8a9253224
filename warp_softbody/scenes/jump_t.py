"""Letter T jumps with a twist (the paper's jumping T)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_t
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.jump import Jump, JumpGains
from warp_softbody.scenes.jump_i import LANDING, start
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 9.6e5  # Pa
POISSON_RATIO = 0.48
STIFFNESS_DAMPING = 0.04  # s

TWIST = JumpGains(
    depth=0.2,  # m
    wind=-1.2,  # rad
    crouch_time=0.54,  # s
    launch=(0.0, 0.0, 3.0),  # m/s
    push=29.0,  # 1/s
    spin=7.2,  # 1/s
    turn=0.5,  # m g times 1 m
    momentum_weight=0.05,  # of rows in m g dt
    spin_weight=2.2,  # of rows in m g dt times 1 m
    reach=(0.0, 0.0, -0.55),  # m
    activation=ActivationCost(effort=0.015, change=0.75),
    landing=replace(
        LANDING,
        position=30.0,
        velocity=9.0,
        spin_weight=3.0,
        activation=ActivationCost(effort=0.08, change=3.5),
        relax=160.0,
        relax_within=0.2,  # m
    ),
    ease=2.0,
)
"""By hand, from the jump in place: wound up as it crouches, the letter unwinds as it pushes. The
relaxing ends the sway with friction, stiffness and strength 20 % off too."""

FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)


def twisting_letter() -> Character:
    """Letter T with stronger muscles and less damping."""
    letter = letter_t()
    return replace(
        letter,
        material=replace(
            letter.material,
            volume="exact",
            poisson_ratio=POISSON_RATIO,
            stiffness_damping=STIFFNESS_DAMPING,
        ),
        muscles=tuple(replace(group, strength=STRENGTH) for group in letter.muscles),
    )


def build(values: Values) -> tuple[Scene, Jump]:
    """One jump on the spot, anticlockwise seen from above."""
    character = twisting_letter()
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, Jump(TWIST, start=start(values))


RECIPE = SceneRecipe(
    name="jump-t",
    description="letter T jumps, turns in the air and lands on its foot",
    settings=(PUSH, PUSH_SETTINGS[1], FRICTION),
    build=build,
    seconds=4.5,
    time_step=1.0 / 60.0,
)
