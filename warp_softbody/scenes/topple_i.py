"""Letter I falls without muscles after the push that `balance-i` recovers from."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.scenes.balance_i import balancing_letter
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene


def build(values: Values) -> tuple[Scene, None]:
    """The letter without muscles on a floor, and a push at its head."""
    character = replace(balancing_letter(), muscles=())
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, None


RECIPE = SceneRecipe(
    name="topple-i",
    description="letter I without muscles falls over after a push at its head",
    settings=tuple(
        replace(setting, default=0.5) if setting.name == "push" else setting
        for setting in PUSH_SETTINGS
    ),
    build=build,
    seconds=3.0,
)
