"""Letter I keeps its balance after a push at the head (METHOD section 6, "balance I")."""

from __future__ import annotations

from warp_softbody.characters import letter_i
from warp_softbody.controllers.balance import Balance, BalanceGains
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.ground import Plane
from warp_softbody.scene import Scene
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push

GAINS = BalanceGains(
    position=15.0,  # 1/s^2
    velocity=8.0,  # 1/s
    spin=6.0,  # 1/s
    momentum_weight=1.0,  # of rows in m g dt
    spin_weight=40.0,  # of rows in m g dt times 1 m
    activation=ActivationCost(effort=0.02, change=5.0),
)
"""Values with which a rough trial on a coarser letter I survived a push of 0.42 body weights."""


def build(values: Values) -> tuple[Scene, Balance]:
    """The letter on a floor, a push at its head, and the balance controller."""
    character = letter_i()
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, Balance(GAINS)


RECIPE = SceneRecipe(
    name="balance-i",
    description="letter I recovers from a push at its head",
    settings=PUSH_SETTINGS,
    build=build,
    seconds=6.0,
)
