"""A held sole: its rows see what slides, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES
from warp_softbody.controllers.motions.held_sole import HeldSole
from warp_softbody.scenes import jump_i
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView

RATE, STEP = 4.0, 0.02  # 1/s, s


def standing() -> BodyView:
    """The letter as it stands, at rest."""
    scene = Scene(character=jump_i.jumping_letter(), ground=Plane(friction=0.8))
    places = scene.character.mesh.points
    return BodyView(
        scene=scene,
        time=0.0,
        time_step=STEP,
        masses=np.full(len(places), 1.0 / len(places)),
        positions=places,
        velocities=np.zeros_like(places),
        touching=np.zeros(len(places), dtype=bool),
        activations=np.ones(0),
    )


def seen(velocities: FloatArray) -> FloatArray:
    """What the rows make of velocities (n, 3), in m/s."""
    view = standing()
    (objective,) = HeldSole("base", BASE_PATCHES).objectives(view, RATE, 0.5)
    unit = 9.81 * STEP / np.sqrt(len(BASE_PATCHES))
    return np.asarray(objective.rows @ velocities.ravel() * unit)


def test_sliding_is_seen_as_it_is() -> None:
    view = standing()
    sliding = np.tile([0.3, -0.2, 0.7], (view.node_count, 1))
    np.testing.assert_allclose(seen(sliding), [0.3, -0.2, 0.0, 0.0], atol=1e-12)


def test_widening_is_seen_at_the_middles_of_its_parts() -> None:
    """Of a sole a wide and b deep that widens by a rate r the parts' middles move by r a / 4."""
    view = standing()
    base = view.positions[view.scene.character.region("base")]
    wide, deep, _ = np.ptp(base, axis=0)
    widening = (view.positions - base.mean(axis=0)) * [0.4, 0.1, 9.0]
    found = seen(widening)
    np.testing.assert_allclose(found[2:], [0.1 * wide, 0.025 * deep], rtol=0.05)
    assert np.abs(found[:2]).max() < 0.05 * found[2]


def test_turning_is_not_seen() -> None:
    view = standing()
    arms = view.positions - view.positions[view.scene.character.region("base")].mean(axis=0)
    turning = np.cross([0.0, 0.0, 1.0], arms)
    assert np.abs(seen(turning)).max() < 0.02


def test_what_slides_is_to_come_to_rest_as_in_an_implicit_step() -> None:
    view = standing()
    moving = replace(view, velocities=np.random.default_rng(0).normal(size=view.velocities.shape))
    (objective,) = HeldSole("base", BASE_PATCHES).objectives(moving, RATE, 0.5)
    now = objective.rows @ moving.velocities.ravel()
    assert objective.target == pytest.approx(now / (1.0 + RATE * STEP), rel=1e-12)
    assert np.all(objective.weight == 0.5)


def test_a_sole_of_one_part_can_only_slide() -> None:
    """Whose middle is its own, but for rounding."""
    (objective,) = HeldSole("base", ("base",)).objectives(standing(), RATE, 0.5)
    assert objective.rows[:2].any(axis=1).all() and not objective.rows[2:].any()


def test_without_a_weight_nothing_is_asked() -> None:
    assert HeldSole("base", BASE_PATCHES).objectives(standing(), RATE, 0.0) == ()
