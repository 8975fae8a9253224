"""Motions in scenes with further bodies, without gravity, and from the first step on."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i, letter_o, letter_x
from warp_softbody.controllers import (
    ONE_BY_ONE,
    Balance,
    BalanceGains,
    Controller,
    Crawl,
    Leg,
    Roll,
    Slide,
    Walk,
)
from warp_softbody.errors import InputError
from warp_softbody.world.ground import Plane
from warp_softbody.world.joined_bodies import Body
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

LEGS = (Leg(direction=1.0, turn=3.0),)
CRAWLER = scenes.make("crawl-i", {}).scene.character
SCENES: dict[str, tuple[Character, Callable[[], Controller]]] = {
    "balance": (letter_i(), lambda: Balance(BalanceGains(upright_weight=1.0))),
    "crawl": (CRAWLER, Crawl),
    "roll": (letter_o(), lambda: Roll(legs=LEGS, rim="rim")),
    "slide": (letter_i(), Slide),
    "walk": (letter_x(), lambda: Walk(gait=ONE_BY_ONE, start=0.0)),
}


def standing(scene: Scene) -> BodyView:
    """The scene at its start, its character bent a little."""
    points, count = scene.whole.mesh.points, len(scene.character.mesh.points)
    bent = points + 0.05 * np.sin(points[:, [1, 2, 0]])
    return BodyView(
        scene=scene,
        time=0.0,
        time_step=1.0 / 60.0,
        masses=np.where(np.arange(len(points)) < count, 0.1, 0.0),
        positions=bent,
        velocities=0.1 * bent,
        touching=np.zeros(len(points), dtype=bool),
        activations=np.ones(scene.character.segment_count),
    )


@pytest.mark.parametrize("name", SCENES)
def test_a_motion_asks_the_same_beside_another_body(name: str) -> None:
    character, controller = SCENES[name]
    alone = Scene(character=character, ground=Plane())
    mesh = character.mesh
    far = replace(mesh, points=mesh.points + np.array([5.0, 0.0, 0.0]))
    other = replace(character, name="Other", mesh=far, muscles=())
    beside = replace(alone, others=(Body(character=other),))
    ours: Controller = controller()
    theirs: Controller = controller()
    wanted, found = ours.goals(standing(alone)), theirs.goals(standing(beside))
    assert wanted is not None and found is not None
    for one, two in zip(wanted.objectives, found.objectives, strict=True):
        columns = one.rows.shape[1]
        # sums over more nodes are rounded otherwise
        np.testing.assert_allclose(two.rows[:, :columns], one.rows, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(two.target, one.target, rtol=1e-9, atol=1e-12)
        assert not two.rows[:, columns:].any()
    for patch, same in zip(wanted.patches, found.patches, strict=True):
        np.testing.assert_allclose(same.factors, patch.factors, rtol=1e-9)


def test_rolling_without_gravity_is_refused_in_a_sentence() -> None:
    scene = Scene(character=letter_o(), ground=Plane(), gravity=(0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="needs gravity"):
        Roll(legs=LEGS, rim="rim").goals(standing(scene))


@pytest.mark.parametrize(
    "name", ["balance-i", "leap-i", "jump-i", "walk-x", "exercise-h", "flip-i"]
)
def test_scenes_without_gravity_are_refused_and_nothing_is_warned_of(name: str) -> None:
    plan = scenes.make(name)
    assert plan.controller is not None
    view = standing(replace(plan.scene, gravity=(0.0, 0.0, 0.0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match="needs gravity"):
            plan.controller.goals(view)
