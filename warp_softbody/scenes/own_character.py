"""A character from a user's file stands on a floor, where it does what it is asked to."""

from __future__ import annotations

from pathlib import Path

from warp_softbody.body.character import Character
from warp_softbody.body.character_files import EXTENSION
from warp_softbody.body.lessons import read_lessons
from warp_softbody.body.mesh_files import FORMATS, SURFACES
from warp_softbody.controllers.controller import Controller
from warp_softbody.errors import InputError
from warp_softbody.scenes.doings import asked, controller_of, settings_of
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene


def recipe(name: str, do: str | None = None) -> SceneRecipe:
    """The scene of a character's file, in which it does one of `DOINGS`, or several in turn.

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
    steps = asked("balance" if do is None else do)
    character = Character.load(name)
    taught = read_lessons(Path(name))

    def build(values: Values) -> tuple[Scene, Controller | None]:
        scene = Scene(
            character=character,
            ground=Plane(friction=values["friction"]),
            pushes=head_push(character, values),
        )
        if do is None and not character.muscles:
            return scene, None
        return scene, controller_of(steps, character, values, taught)

    return SceneRecipe(
        name=character.name,
        description=f"{character.name} {', then '.join(step.doing.tells for step in steps)}",
        settings=settings_of(steps),
        build=build,
        seconds=sum(step.ends.get("seconds", step.doing.seconds) for step in steps),
        time_step=1.0 / 60.0,
    )
