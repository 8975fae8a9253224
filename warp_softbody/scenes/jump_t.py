"""Letter T jumps with a twist (the paper's jumping T)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_t
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.jump import Jump
from warp_softbody.controllers.motions.jump_gains import JumpGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.jump_i import IN_PLACE, LANDING, START, sole, start
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 2.6  # E
POISSON_RATIO = 0.49
STIFFNESS_DAMPING = 0.022  # s

TWIST = replace(
    IN_PLACE,
    depth=0.175,  # L
    crouch_share=0.9,
    wind=-0.9,  # rad
    launch=(0.0, 0.0, 0.415),  # sqrt(g L)
    turn=1.3,  # rad
    push_spin=12.0,  # sqrt(g/L)
    spin_weight=15.0,  # of rows in m g L dt
    height=0.45,  # L
    activation=ActivationCost(effort=0.02, change=0.0157),
    landing=replace(
        LANDING,
        activation=ActivationCost(effort=0.08, change=0.1096),
        relax=160.0,
        relax_within=0.2,  # L
    ),
)
"""By hand, from the jump in place: wound up as it crouches, the letter unwinds as it pushes. The
dearer effort ends a lean into which it crept."""

FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)


def twisting_letter(coarse: float = 0.0) -> Character:
    """Letter T with stronger muscles and less damping."""
    letter = letter_t(coarse=int(coarse))
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


def jumper(gains: JumpGains, start: float = START) -> Jump:
    """What makes the letter jump once, its sole kept flat."""
    return Jump(gains, start=start, resting=sole(twisting_letter()))


def build(values: Values) -> tuple[Scene, Jump]:
    """One jump on the spot, anticlockwise seen from above."""
    character = twisting_letter(values["coarse"])
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, jumper(TWIST, start(values))


RECIPE = SceneRecipe(
    name="jump-t",
    description="letter T jumps, turns in the air and lands on its foot",
    settings=(PUSH, PUSH_SETTINGS[1], FRICTION, coarse_setting("letter_t")),
    build=build,
    seconds=4.5,
    time_step=1.0 / 60.0,
)
