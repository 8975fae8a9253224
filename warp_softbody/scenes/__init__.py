"""The shipped scenes have a file each, with the controller and its gains."""

from __future__ import annotations

from collections.abc import Mapping

from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.scenes import (
    balance_i,
    bounce_ball,
    cantilever,
    crawl_i,
    drop_block,
    exercise_h,
    jump_i,
    jump_t,
    roll_o,
    rough_ground,
    slide_f,
    slope,
    stack,
    stairs,
    topple_i,
    twisted_bar,
    walk_x,
)
from warp_softbody.scenes.plan import ScenePlan, SceneRecipe, Setting, suggestion

__all__ = ["ScenePlan", "SceneRecipe", "Setting", "make", "names", "recipe"]

_RECIPES = {
    scene.name: scene
    for scene in (
        balance_i.RECIPE,
        jump_i.JUMP_I,
        jump_i.JUMP_I_IN_PLACE,
        jump_t.RECIPE,
        roll_o.ROLL_O,
        roll_o.ROLL_O_RETURN,
        crawl_i.CRAWL_I,
        crawl_i.CRAWL_I_INCHWORM,
        walk_x.WALK_X,
        walk_x.WALK_X_FAST,
        exercise_h.RECIPE,
        slide_f.SLIDE_F,
        slide_f.SLIDE_F_LEFT,
        slide_f.SLIDE_F_DELAYED,
        topple_i.RECIPE,
        drop_block.RECIPE,
        slope.RECIPE,
        stack.RECIPE,
        stairs.RECIPE,
        rough_ground.RECIPE,
        cantilever.RECIPE,
        twisted_bar.RECIPE,
        bounce_ball.RECIPE,
    )
}


def names() -> tuple[str, ...]:
    """Return the names of all scenes."""
    return tuple(_RECIPES)


def recipe(name: str) -> SceneRecipe:
    """Return the recipe of a scene; an unknown name raises with close matches."""
    if not isinstance(name, str):
        checks.refuse("name of a scene", "a text", name)
    if name not in _RECIPES:
        raise InputError(
            f"there is no scene {checks.shown(name)}; {suggestion(name, list(_RECIPES))}"
        )
    return _RECIPES[name]


def make(name: str, settings: Mapping[str, str | float] | None = None) -> ScenePlan:
    """Return a scene with its controller, ready to be run.

    Args:
        name: one of `names()`.
        settings: numbers, or texts that hold numbers, by name; see `recipe(name).settings`.

    Raises:
        InputError: one sentence that names the scene or the setting at fault and what is known.
    """
    return recipe(name).make({} if settings is None else settings)
