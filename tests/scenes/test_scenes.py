"""The registry of scenes and the settings that it takes."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.errors import InputError


@pytest.mark.parametrize("name", scenes.names())
def test_every_scene_is_made_from_its_defaults(name: str) -> None:
    plan = scenes.make(name)
    recipe = scenes.recipe(name)
    assert (plan.name, plan.description) == (name, recipe.description)
    assert plan.settings == {setting.name: setting.default for setting in recipe.settings}
    assert plan.seconds > 0.0 and plan.time_step > 0.0
    assert (plan.controller is None) == (plan.scene.character.segment_count == 0)


def test_push_is_in_body_weights() -> None:
    plan = scenes.make("balance-i", {"push": "0.42", "push_seconds": 0.1})
    (push,) = plan.scene.pushes
    character = plan.scene.character
    weight = character.material.density * character.mesh.volume * 9.81
    np.testing.assert_allclose(push.force, (0.42 * weight, 0.0, 0.0))
    assert (push.region, push.start, push.duration) == ("head", 0.5, 0.1)


def test_no_push_and_another_floor() -> None:
    plan = scenes.make("balance-i", {"push": 0, "friction": 0.2})
    assert plan.scene.pushes == ()
    assert plan.scene.ground is not None and plan.scene.ground.friction == 0.2


def test_controllers_are_not_shared_between_plans() -> None:
    assert scenes.make("balance-i").controller is not scenes.make("balance-i").controller


def test_mistakes_name_what_is_known() -> None:
    with pytest.raises(InputError, match=r"no scene 'topple'; did you mean 'topple-i'\?"):
        scenes.make("topple")
    with pytest.raises(InputError, match="no setting 'colour'; known: push, push_seconds, fric"):
        scenes.make("balance-i", {"colour": 1.0})
    for value in ("much", "", 3.0, float("nan"), "inf"):
        with pytest.raises(InputError, match="'push' must be a number from -2 to 2 body weights"):
            scenes.make("balance-i", {"push": value})
