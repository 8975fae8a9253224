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

STRENGTH = 1.92  # E
POISSON_RATIO = 0.48
STIFFNESS_DAMPING = 0.04  # s

TWIST = JumpGains(
    depth=0.2,  # L
    wind=-1.2,  # rad
    crouch_time=1.691,  # sqrt(L/g)
    launch=(0.0, 0.0, 0.9578),  # sqrt(g L)
    push=9.259,  # sqrt(g/L)
    spin=2.299,  # sqrt(g/L)
    turn=0.5,  # m g L
    momentum_weight=0.05,  # of rows in m g dt
    spin_weight=2.2,  # of rows in m g L dt
    reach=(0.0, 0.0, -0.55),  # L
    activation=ActivationCost(effort=0.015, change=0.02349),
    landing=replace(
        LANDING,
        position=3.058,  # g/L
        velocity=2.873,  # sqrt(g/L)
        spin_weight=3.0,
        activation=ActivationCost(effort=0.08, change=0.1096),
        relax=160.0,
        relax_within=0.2,  # L
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
    strength = STRENGTH * letter.material.young_modulus
    return replace(
        letter,
        material=replace(
            letter.material,
            volume="exact",
            poisson_ratio=POISSON_RATIO,
            stiffness_damping=STIFFNESS_DAMPING,
        ),
        muscles=tuple(replace(group, strength=strength) for group in letter.muscles),
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
