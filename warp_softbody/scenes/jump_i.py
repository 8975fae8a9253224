"""Letter I jumps forward, and in place (the paper's jumping I)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.jump import Jump, JumpGains
from warp_softbody.ground import Plane
from warp_softbody.scene import Scene
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push

STRENGTH = 9e5
"""Pa: muscles can only pull, so a jump is what a crouched body does when it lets go, and its height
is set by how far the muscles can crouch it."""

STIFFNESS_DAMPING = 0.025  # s, of a body that springs

FORWARD = JumpGains(
    depth=0.24,  # m
    lean=(0.025, 0.0),  # m
    crouch_time=0.6,  # s
    launch=(2.8, 0.0, 3.0),  # m/s, more than it reaches
    push=17.0,  # 1/s
    spin=2.5,  # 1/s
    spin_weight=3.75,  # of rows in m g dt times 1 m
    reach=(0.09, 0.0, -0.49),  # m
    activation=ActivationCost(effort=0.015, change=0.18),
)
"""The middle of the eight best of 150 random draws for a far jump that ends upright; checked with
friction and stiffness 20 % up and down."""

IN_PLACE = JumpGains(
    depth=0.2,  # m
    launch=(0.0, 0.0, 4.0),  # m/s
    activation=ActivationCost(effort=0.015, change=2.0),
)
"""The first of a grid of eight; all of them land upright."""

FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
PUSH_SECONDS = PUSH_SETTINGS[1]
START = 1.0  # s, so that a push at the head comes before the jump


def jumping_letter() -> Character:
    """Letter I with stronger muscles and less damping."""
    letter = letter_i()
    return replace(
        letter,
        material=replace(letter.material, stiffness_damping=STIFFNESS_DAMPING),
        muscles=tuple(replace(group, strength=STRENGTH) for group in letter.muscles),
    )


def _scene(values: Values) -> Scene:
    character = jumping_letter()
    return Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )


def build_forward(values: Values) -> tuple[Scene, Jump]:
    """One jump along +x."""
    return _scene(values), Jump(FORWARD, start=START)


def build_in_place(values: Values) -> tuple[Scene, Jump]:
    """Jumps on the spot."""
    return _scene(values), Jump(IN_PLACE, jumps=int(values["jumps"]), start=START)


JUMP_I = SceneRecipe(
    name="jump-i",
    description="letter I jumps forward and lands on its base",
    settings=(PUSH, PUSH_SECONDS, FRICTION),
    build=build_forward,
    seconds=4.5,
    time_step=1.0 / 60.0,
)

JUMP_I_IN_PLACE = SceneRecipe(
    name="jump-i-in-place",
    description="letter I jumps three times on the spot",
    settings=(
        Setting(name="jumps", default=3, low=1, high=100, help="how many"),
        PUSH,
        PUSH_SECONDS,
        FRICTION,
    ),
    build=build_in_place,
    seconds=8.0,
    time_step=1.0 / 60.0,
)
