"""The shipped scenes have a file each, with the controller and its gains."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.scenes.plan import ScenePlan, SceneRecipe, Setting, suggestion

__all__ = ["ScenePlan", "SceneRecipe", "Setting", "make", "names", "recipe"]

_HOMES = {
    "balance-i": ("balance_i", "RECIPE"),
    "jump-i": ("jump_i", "JUMP_I"),
    "jump-i-in-place": ("jump_i", "JUMP_I_IN_PLACE"),
    "leap-i": ("leap_i", "RECIPE"),
    "jump-t": ("jump_t", "RECIPE"),
    "roll-o": ("roll_o", "ROLL_O"),
    "roll-o-return": ("roll_o", "ROLL_O_RETURN"),
    "crawl-i": ("crawl_i", "CRAWL_I"),
    "crawl-i-inchworm": ("crawl_i", "CRAWL_I_INCHWORM"),
    "walk-x": ("walk_x", "WALK_X"),
    "walk-x-fast": ("walk_x", "WALK_X_FAST"),
    "walk-x-eight": ("walk_x", "WALK_X_EIGHT"),
    "flip-i": ("flip_i", "RECIPE"),
    "cartwheel-x": ("cartwheel_x", "RECIPE"),
    "exercise-h": ("exercise_h", "RECIPE"),
    "slide-f": ("slide_f", "SLIDE_F"),
    "slide-f-left": ("slide_f", "SLIDE_F_LEFT"),
    "slide-f-delayed": ("slide_f", "SLIDE_F_DELAYED"),
    "topple-i": ("topple_i", "RECIPE"),
    "drop-block": ("drop_block", "RECIPE"),
    "slope": ("slope", "RECIPE"),
    "stack": ("stack", "RECIPE"),
    "stairs": ("stairs", "RECIPE"),
    "rough-ground": ("rough_ground", "RECIPE"),
    "cantilever": ("cantilever", "RECIPE"),
    "twisted-bar": ("twisted_bar", "RECIPE"),
    "bounce-ball": ("bounce_ball", "RECIPE"),
}
"""The file and the name of each scene's recipe; a file is read when its scene is asked for."""


def names() -> tuple[str, ...]:
    """Return the names of all scenes."""
    return tuple(_HOMES)


def recipe(name: str, do: str | None = None) -> SceneRecipe:
    """Return the recipe of a scene, or that of a character's file (.char).

    Args:
        name: of a scene or a file.
        do: what the character of a file does: "balance", which is usual, "walk", "crawl", "jump",
            "hop" or "roll", or several in turn, as "walk:2m,jump,balance:3s".

    Raises:
        InputError: an unknown name, with close matches; a file that holds no character.
    """
    if not isinstance(name, str):
        checks.refuse("name of a scene", "a text", name)
    if Path(name).suffix:
        home, attribute = "own_character", "recipe"
        own: SceneRecipe = getattr(import_module(f"{__name__}.{home}"), attribute)(name, do)
        return own
    if do is not None:
        raise InputError(
            f"--do is for the character of a file, NAME.char, not for scene {checks.shown(name)}"
        )
    if name not in _HOMES:
        raise InputError(
            f"there is no scene {checks.shown(name)}; {suggestion(name, list(_HOMES))}"
        )
    home, attribute = _HOMES[name]
    found: SceneRecipe = getattr(import_module(f"{__name__}.{home}"), attribute)
    return found


def make(
    name: str, settings: Mapping[str, str | float] | None = None, do: str | None = None
) -> ScenePlan:
    """Return a scene with its controller, ready to be run.

    Args:
        name: one of `names()`.
        settings: numbers, or texts that hold numbers, by name; see `recipe(name).settings`.
        do: what the character of a file does (`recipe`).

    Raises:
        InputError: one sentence that names the scene or the setting at fault and what is known.
    """
    return recipe(name, do).make({} if settings is None else settings)
