"""A character from a user's file stands on a floor, is pushed and keeps its balance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from warp_softbody.body.character import Character
from warp_softbody.body.character_files import EXTENSION
from warp_softbody.body.mesh_files import FORMATS, SURFACES
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.errors import InputError
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

PUSH = replace(PUSH_SETTINGS[0], default=0.15)
"""One that a body without gains of its own should bear."""


def recipe(name: str) -> SceneRecipe:
    """The scene of a character's file.

    Raises:
        InputError: the file is missing, of another kind, or holds no character.
    """
    suffix = Path(name).suffix.lower()
    if suffix in (*SURFACES, ".glb", *FORMATS):
        raise InputError(
            f"{name} is a shape and no scene; `warp-softbody character {name} -o "
            f"{Path(name).stem}.char` makes a character of it, which can be run"
        )
    if suffix != EXTENSION:
        raise InputError(
            f"there is no scene {name!r}; a character's file, which can be run, ends in {EXTENSION}"
        )
    character = Character.load(name)

    def build(values: Values) -> tuple[Scene, Balance | None]:
        scene = Scene(
            character=character,
            ground=Plane(friction=values["friction"]),
            pushes=head_push(character, values),
        )
        return scene, Balance.for_(character) if character.muscles else None

    return SceneRecipe(
        name=character.name,
        description=f"{character.name} keeps its balance after a push at its head",
        settings=(PUSH, *PUSH_SETTINGS[1:]),
        build=build,
        seconds=5.0,
        time_step=1.0 / 60.0,
    )
