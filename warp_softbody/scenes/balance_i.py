"""Letter I keeps its balance after a push at the head (the paper's balancing I)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance import Balance, BalanceGains
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

GAINS = BalanceGains(
    position=2.0,  # g/L
    velocity=2.6,  # sqrt(g/L)
    spin=5.0,  # sqrt(g/L)
    upright=4.0,  # sqrt(g/L)
    upright_weight=0.3,  # of rows in g dt
    crouch=0.1,  # of the offset
    momentum_weight=0.01,  # of rows in m g dt
    spin_weight=0.02,  # of rows in m g L dt
    base_weight=0.1,  # of rows in sqrt(g/L)
    base_rate=1.277,  # sqrt(g/L)/L
    activation=ActivationCost(effort=0.3, change=0.03),
    relax=20.0,
    relax_within=0.1,  # L
)
"""By hand, one gain after the other, on twice and half the step, two iterations and pushes of 0.45
and 0.5. Momenta count little: a plan that asks more of them than contact at the edge of the base
can give bends the body until it falls."""

YOUNG_MODULUS = 1e6  # Pa
STRENGTH = 1.5  # E
POISSON_RATIO = 0.48  # the volume changes by 1 %
STIFFNESS_DAMPING = 0.04  # s

PUSH = replace(PUSH_SETTINGS[0], default=0.45)
"""One that topples the QP in which touching contacts hold still."""


def balancing_letter() -> Character:
    """Letter I, firmer, with stronger muscles, and of a volume that hardly changes."""
    letter = letter_i()
    material = replace(
        letter.material,
        volume="exact",
        young_modulus=YOUNG_MODULUS,
        poisson_ratio=POISSON_RATIO,
        stiffness_damping=STIFFNESS_DAMPING,
    )
    strength = STRENGTH * YOUNG_MODULUS
    muscles = tuple(replace(group, strength=strength) for group in letter.muscles)
    return replace(letter, material=material, muscles=muscles)


def build(values: Values) -> tuple[Scene, Balance]:
    """The letter on a floor, a push at its head, and the balance controller."""
    character = balancing_letter()
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, Balance(GAINS)


RECIPE = SceneRecipe(
    name="balance-i",
    description="letter I recovers from a push at its head",
    settings=(PUSH, *PUSH_SETTINGS[1:]),
    build=build,
    seconds=6.0,
    time_step=1.0 / 60.0,
)
