"""Letter I keeps its balance after a push at the head (the paper's balancing I)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.balance_gains import LETTER
from warp_softbody.controllers.motions.recovery_gains import RecoveryGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

GAINS = LETTER

YOUNG_MODULUS = 1.8e6  # Pa
STRENGTH = 0.67  # E
POISSON_RATIO = 0.48  # the volume changes by 1 %
STIFFNESS_DAMPING = 0.035  # s

PUSH = replace(PUSH_SETTINGS[0], default=0.5)
"""One that topples the QP in which touching contacts hold still."""

HOPS = Setting(
    name="hops",
    whole=True,
    default=1,
    low=0,
    high=1,
    help="whether it hops where it cannot stay on its base: 1, or 0 for never",
)


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
    stays = replace(GAINS, recovery=RecoveryGains())
    return scene, Balance(GAINS if values["hops"] else stays)


RECIPE = SceneRecipe(
    name="balance-i",
    description="letter I recovers from a push at its head",
    settings=(PUSH, *PUSH_SETTINGS[1:], HOPS, coarse_setting("letter_i")),
    build=build,
    seconds=6.0,
    time_step=1.0 / 60.0,
)
