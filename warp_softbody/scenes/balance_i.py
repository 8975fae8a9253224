"""Letter I keeps its balance after a push at the head (the paper's balancing I)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance import Balance, BalanceGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

GAINS = BalanceGains(
    position=2.0,  # g/L
    velocity=2.6,  # sqrt(g/L)
    spin=5.0,  # sqrt(g/L)
    upright=4.0,  # sqrt(g/L)
    upright_weight=0.1,  # of rows in g dt
    follow=0.3,  # of the base's tilt
    lean=0.2,  # of the offset
    height_weight=0.5,  # of upright_weight
    height_rate=3.2,  # sqrt(g/L)
    height_acceleration=3.0,  # g
    squat=2.0,  # of the offset
    least_height=0.75,  # of the height at rest
    skip_from=0.22,  # L
    crouch=0.1,  # of the offset
    momentum_weight=0.02,  # of rows in m g dt
    spin_weight=0.003,  # of rows in m g L dt
    base_weight=0.003,  # of rows in sqrt(g/L)
    base_rate=1.277,  # sqrt(g/L)/L
    activation=ActivationCost(effort=0.1, change=0.028),
    relax=20.0,
    relax_within=0.1,  # L
)
"""By hand, after a search by evolution at pushes of 0.5 to 0.52 with the step, twice and a quarter
of it. Momenta count little: a plan that asks more of them than contact at the edge of the base can
give bends the body until it falls."""

YOUNG_MODULUS = 1.8e6  # Pa
STRENGTH = 0.67  # E
POISSON_RATIO = 0.48  # the volume changes by 1 %
STIFFNESS_DAMPING = 0.035  # s

PUSH = replace(PUSH_SETTINGS[0], default=0.5)
"""One that topples the QP in which touching contacts hold still."""


def balancing_letter(coarse: float = 0.0) -> Character:
    """Letter I, firmer, with stronger muscles, and of a volume that hardly changes."""
    letter = letter_i(coarse=int(coarse))
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
    character = balancing_letter(values["coarse"])
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, Balance(GAINS)


RECIPE = SceneRecipe(
    name="balance-i",
    description="letter I recovers from a push at its head",
    settings=(PUSH, *PUSH_SETTINGS[1:], coarse_setting("letter_i")),
    build=build,
    seconds=6.0,
    time_step=1.0 / 60.0,
)
