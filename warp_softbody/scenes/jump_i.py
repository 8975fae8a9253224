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

STRENGTH = 3.5
"""E: muscles can only pull, so a jump is what a crouched body does when it lets go, and its height
is set by how far the muscles can crouch it."""

STRENGTH_IN_PLACE = 2.3  # E, for which a crouch changes the volume by 3.5 %
POISSON_RATIO = 0.476
STIFFNESS_DAMPING = 0.035  # s, of a body that springs

LANDING = BalanceGains(
    position=2.039,  # g/L
    velocity=1.948,  # sqrt(g/L)
    crouch=0.38,  # of the offset
    momentum_weight=0.05,  # of rows in m g dt
    spin_weight=1.5,  # of rows in m g L dt
    base_weight=0.0,  # widening and momentum at such weights end in a sway that does not stop
    activation=ActivationCost(effort=0.015, change=0.1096),
    relax=40.0,
    relax_within=0.15,  # L
)

FORWARD = JumpGains(
    depth=0.215,  # L
    lean=(0.15, 0.0),  # L
    pitch=1.0,  # rad
    crouch_time=1.973,  # sqrt(L/g)
    launch=(0.7982, 0.0, 0.9897),  # sqrt(g L), more than it reaches
    push=7.184,  # sqrt(g/L)
    rise=0.03132,  # sqrt(L/g)
    position=12.23,  # g/L
    velocity=5.108,  # sqrt(g/L)
    spin=1.564,  # sqrt(g/L)
    momentum_weight=0.033,  # of rows in m g dt
    spin_weight=0.5,  # of rows in m g L dt
    reach=(0.074, 0.0, -0.52),  # L
    reach_weight=5.297,  # of rows in sqrt(g L)
    activation=ActivationCost(effort=0.022, change=0.02192),
    landing=LANDING,
    ease=2.2,
)
"""Searched for the least of what is missing over six variants: other meshes, half the step, and
friction, stiffness and strength 20 % off. A body bent forward as it crouches is flung forward."""

IN_PLACE = JumpGains(
    depth=0.25,  # L
    crouch_time=2.004,  # sqrt(L/g)
    launch=(0.0, 0.0, 0.9259),  # sqrt(g L)
    push=8.94,  # sqrt(g/L)
    rise=0.09396,  # sqrt(L/g)
    spin=2.075,  # sqrt(g/L)
    momentum_weight=0.042,  # of rows in m g dt
    spin_weight=2.2,  # of rows in m g L dt
    reach=(0.0, 0.0, -0.53),  # L
    reach_weight=4.709,  # of rows in sqrt(g L)
    activation=ActivationCost(effort=0.025, change=0.1879),
    landing=replace(LANDING, position=2.854, velocity=2.458, crouch=0.47),
    ease=2.0,
)
"""By hand from a draw for the jump forward; shallow: no variant changes the volume by 5 %."""

FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
PUSH_SECONDS = PUSH_SETTINGS[1]
START = 1.566  # sqrt(L/g)
START_AFTER_PUSH = 3.132  # sqrt(L/g)


def jumping_letter(strength: float = STRENGTH) -> Character:
    """Letter I with muscles of a strength in E, less damping and a volume that hardly changes."""
    letter = letter_i()
    strength *= letter.material.young_modulus
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
    """When the first jump begins, sqrt(L/g): after the push at the head, where there is one."""
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
