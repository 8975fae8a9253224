"""Letter I jumps forward, and in place (the paper's jumping I)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance import BalanceGains
from warp_softbody.controllers.motions.jump import Jump, JumpGains
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 1.75e6
"""Pa: muscles can only pull, so a jump is what a crouched body does when it lets go, and its height
is set by how far the muscles can crouch it."""

STRENGTH_IN_PLACE = 1.15e6  # Pa, for which a crouch changes the volume by 3.5 %
POISSON_RATIO = 0.476
STIFFNESS_DAMPING = 0.035  # s, of a body that springs

LANDING = BalanceGains(
    position=20.0,  # 1/s^2
    velocity=6.1,  # 1/s
    crouch=0.38,  # m per m
    momentum_weight=0.05,  # of rows in m g dt
    spin_weight=1.5,  # of rows in m g dt times 1 m
    base_weight=0.0,  # widening and momentum at such weights end in a sway that does not stop
    activation=ActivationCost(effort=0.015, change=3.5),
    relax=40.0,
    relax_within=0.15,  # m
)

FORWARD = JumpGains(
    depth=0.215,  # m
    lean=(0.15, 0.0),  # m
    pitch=1.0,  # rad
    crouch_time=0.63,  # s
    launch=(2.5, 0.0, 3.1),  # m/s, more than it reaches
    push=22.5,  # 1/s
    rise=0.01,  # s
    position=120.0,  # 1/s^2
    velocity=16.0,  # 1/s
    spin=4.9,  # 1/s
    momentum_weight=0.033,  # of rows in m g dt
    spin_weight=0.5,  # of rows in m g dt times 1 m
    reach=(0.074, 0.0, -0.52),  # m
    reach_weight=0.54,  # s^2/m^2
    activation=ActivationCost(effort=0.022, change=0.7),
    landing=LANDING,
    ease=2.2,
)
"""Searched for the least of what is missing over six variants: other meshes, half the step, and
friction, stiffness and strength 20 % off. A body bent forward as it crouches is flung forward."""

IN_PLACE = JumpGains(
    depth=0.25,  # m
    crouch_time=0.64,  # s
    launch=(0.0, 0.0, 2.9),  # m/s
    push=28.0,  # 1/s
    rise=0.03,  # s
    spin=6.5,  # 1/s
    momentum_weight=0.042,  # of rows in m g dt
    spin_weight=2.2,  # of rows in m g dt times 1 m
    reach=(0.0, 0.0, -0.53),  # m
    reach_weight=0.48,  # s^2/m^2
    activation=ActivationCost(effort=0.025, change=6.0),
    landing=replace(LANDING, position=28.0, velocity=7.7, crouch=0.47),
    ease=2.0,
)
"""By hand from a draw for the jump forward; shallow: no variant changes the volume by 5 %."""

FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
PUSH_SECONDS = PUSH_SETTINGS[1]
START = 0.5  # s
START_AFTER_PUSH = 1.0  # s


def jumping_letter(strength: float = STRENGTH) -> Character:
    """Letter I with stronger muscles, less damping and a volume that hardly changes."""
    letter = letter_i()
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


def _scene(values: Values, strength: float) -> Scene:
    character = jumping_letter(strength)
    return Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )


def start(values: Values) -> float:
    """When the first jump begins, s: after the push at the head, where there is one."""
    return START_AFTER_PUSH if values["push"] else START


def build_forward(values: Values) -> tuple[Scene, Jump]:
    """One jump along +x."""
    return _scene(values, STRENGTH), Jump(FORWARD, start=start(values))


def build_in_place(values: Values) -> tuple[Scene, Jump]:
    """Jumps on the spot."""
    controller = Jump(IN_PLACE, jumps=int(values["jumps"]), start=start(values))
    return _scene(values, STRENGTH_IN_PLACE), controller


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
        Setting(name="jumps", whole=True, default=3, low=1, high=100, help="how many"),
        PUSH,
        PUSH_SECONDS,
        FRICTION,
    ),
    build=build_in_place,
    seconds=8.0,
    time_step=1.0 / 60.0,
)
