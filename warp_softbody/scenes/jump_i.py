"""Letter I jumps forward, and in place (the paper's jumping I)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance_gains import BalanceGains
from warp_softbody.controllers.motions.jump import Jump
from warp_softbody.controllers.motions.jump_gains import JumpGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 4.0
"""E: muscles can only pull, so a jump is what a crouched body does when it lets go; muscles this
strong crouch it by a third and can still hold back."""

POISSON_RATIO = 0.48
STIFFNESS_DAMPING = 0.025  # s, of a body that springs

LANDING = BalanceGains(
    position=2.039,  # g/L
    velocity=1.948,  # sqrt(g/L)
    crouch=0.38,  # of the offset
    momentum_weight=0.05,  # of rows in m g dt
    spin_weight=1.5,  # of rows in m g L dt
    upright=3.0,  # sqrt(g/L)
    upright_weight=0.003,  # of rows in g dt: without it a body may come to rest bent
    base_weight=0.0,  # widening and momentum at such weights end in a sway that does not stop
    activation=ActivationCost(effort=0.1, change=0.16),
    relax=40.0,
    relax_within=0.15,  # L
)

IN_PLACE = JumpGains(
    depth=0.15,  # L: as low as muscles come that still have something to spare
    crouch_time=1.88,  # sqrt(L/g)
    crouch_share=0.85,
    launch=(0.0, 0.0, 0.405),  # sqrt(g L)
    rise=0.44,  # sqrt(L/g)
    push=9.6,  # sqrt(g/L)
    push_spin=6.4,  # sqrt(g/L)
    position=4.6,  # g/L
    velocity=2.87,  # sqrt(g/L)
    spin=2.55,  # sqrt(g/L)
    momentum_weight=1.0,  # of rows in m g dt
    spin_weight=5.0,  # of rows in m g L dt
    sole_weight=0.003,  # of rows in g dt
    sole_rate=12.0,  # sqrt(g/L)
    play=0.06,  # L
    height=0.39,  # L
    reach_rate=4.5,  # sqrt(g/L)
    reach_weight=30.0,  # of rows in sqrt(g L)
    rest_time=2.8,  # sqrt(L/g)
    activation=ActivationCost(effort=0.02, change=0.12),
    landing=LANDING,
    ease=2.2,
)
"""By hand: what is asked at take-off is within reach of every mesh, step and tangent, so that the
jump is what was asked. A change costs enough that muscles do not chatter at the bottom."""

FORWARD = replace(
    IN_PLACE,
    launch=(0.08, 0.0, 0.405),  # sqrt(g L)
    way=(0.09, 0.0),  # L
    rest_time=2.5,  # sqrt(L/g)
)
"""Short hops: the foot is as wide as the letter is high by half, and to throw the body further
ahead of it the stem would have to bend more than its muscles can."""

HOPS = 4

FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
PUSH_SECONDS = PUSH_SETTINGS[1]
START = 1.566  # sqrt(L/g)
START_AFTER_PUSH = 3.132  # sqrt(L/g)


def jumping_letter(coarse: float = 0.0) -> Character:
    """Letter I with stronger muscles, less damping and a volume that hardly changes."""
    letter = letter_i(coarse=int(coarse))
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


def sole(character: Character) -> tuple[int, ...]:
    """The lowest segment of every fibre: where these contract, the sole curls."""
    counts = [len(fiber.vertices) - 1 for group in character.muscles for fiber in group.fibers]
    return tuple(int(first) for first in np.cumsum([0, *counts[:-1]]))


def _scene(values: Values) -> Scene:
    character = jumping_letter(values["coarse"])
    return Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )


def start(values: Values) -> float:
    """When the first jump begins, sqrt(L/g): after the push at the head, where there is one."""
    return START_AFTER_PUSH if values["push"] else START


def jumper(gains: JumpGains, *, jumps: int, start: float = START) -> Jump:
    """What makes the letter jump, its sole kept flat."""
    return Jump(gains, jumps=jumps, start=start, resting=sole(jumping_letter()))


def build_forward(values: Values) -> tuple[Scene, Jump]:
    """Hops along +x."""
    return _scene(values), jumper(FORWARD, jumps=HOPS, start=start(values))


def build_in_place(values: Values) -> tuple[Scene, Jump]:
    """Jumps on the spot."""
    return _scene(values), jumper(IN_PLACE, jumps=int(values["jumps"]), start=start(values))


JUMP_I = SceneRecipe(
    name="jump-i",
    description="letter I hops forward four times and lands on its base",
    settings=(PUSH, PUSH_SECONDS, FRICTION, coarse_setting("letter_i")),
    build=build_forward,
    seconds=8.5,
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
        coarse_setting("letter_i", shipped=2),
    ),
    build=build_in_place,
    seconds=8.0,
    time_step=1.0 / 60.0,
)
