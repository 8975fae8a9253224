"""Friction that depends on the direction of sliding in the body's own frame."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.bodies import Rig, box, rig, turned
from tests.verification.scaly_slab import BASE, DT, EIGHT, STIFF, G, scaly_slab
from warp_softbody.body.character import Character
from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.errors import InputError
from warp_softbody.world.ground import Plane
from warp_softbody.world.view import BodyView

EIGHTHS = 2.0 * math.pi * np.arange(8) / 8


def measured_friction(body: Rig, angle: float) -> float:
    """Deceleration over g along a throw at an angle, while the slab slides."""
    body.step(50)
    way = np.array([math.cos(angle), math.sin(angle), 0.0])
    body.place(velocities=2.0 * way)
    body.step(5)
    before = body.momentum @ way
    body.step(10)
    return float((before - body.momentum @ way) / (body.masses.sum() * G * 10 * DT))


@pytest.mark.parametrize("index", range(8))
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_friction_in_eight_directions_is_that_set(index: int, turn: float) -> None:
    """By 1 %.

    In steady sliding a node's friction is on its bound to the solver's residual; what is left is
    the turn of the slab on its way, less than a degree.
    """
    angle = turn + index * math.pi / 4
    measured = measured_friction(scaly_slab(turn=turn), angle)
    assert measured == pytest.approx(BASE * EIGHT[index], rel=0.01)


def test_factors_between_directions_are_interpolated() -> None:
    """Sideways forces do not turn the way of sliding: friction opposes it."""
    angle = 2.5 * math.pi / 4
    measured = measured_friction(scaly_slab(), angle)
    assert measured == pytest.approx(BASE * 0.5 * (EIGHT[2] + EIGHT[3]), rel=0.01)


def test_the_direction_turns_with_the_body() -> None:
    """Laid down turned by a quarter, forward at rest still +x, it slides as it faces."""
    body = scaly_slab()
    body.place(positions=turned(body.positions, (0.0, 0.0, 1.0), math.pi / 2))
    assert measured_friction(body, math.pi / 2) == pytest.approx(BASE * EIGHT[0], rel=0.01)
    assert measured_friction(body, 0.0) == pytest.approx(BASE * EIGHT[6], rel=0.01)


def test_a_shaken_slab_drifts_the_easy_way() -> None:
    """Pushed to and fro alike, it moves forward, where friction is a tenth of that backward.

    One alike both ways stays within the way of its first strokes.
    """
    drifts = []
    for factors in ((1.0, 1.0, 10.0, 1.0), (1.0, 1.0, 1.0, 1.0)):
        body = scaly_slab(factors)
        body.step(50)
        start = body.center[0]
        for k in range(300):
            push = 5.0 * math.sin(2.0 * math.pi * 3.0 * k * DT)
            body.push(np.outer(body.masses, [push, 0.0, 0.0]))
            body.step()
        drifts.append(body.center[0] - start)
    assert drifts[0] > 0.2
    assert abs(drifts[1]) < 0.05


def test_factors_of_one_change_nothing() -> None:
    plain = scaly_slab((1.0,) * 8)
    plain.place(velocities=(1.0, 0.3, 0.0))
    character = plain.model.scene.character
    without = Character(name="slab", mesh=character.mesh, material=STIFF)
    twin = rig(without, ground=Plane(friction=BASE), gravity=(0.0, 0.0, -G), time_step=DT)
    twin.place(velocities=(1.0, 0.3, 0.0))
    plain.step(50)
    twin.step(50)
    np.testing.assert_array_equal(plain.positions, twin.positions)


@pytest.mark.parametrize("slip", [(0.0, 0.0, 0.0), (0.3, 0.5, 0.0)])
@pytest.mark.parametrize("turn", [0.0, math.pi / 2, 0.4])
def test_patches_know_the_factors(turn: float, slip: tuple[float, float, float]) -> None:
    """By the direction of the force, which opposes the sliding, whichever way the polygon lies."""
    body = scaly_slab()
    body.place(positions=turned(body.model.scene.character.mesh.points, (0, 0, 1), turn))
    view = BodyView(
        scene=body.model.scene,
        time=0.0,
        time_step=DT,
        masses=body.masses,
        positions=body.positions,
        velocities=np.tile(slip, (len(body.masses), 1)),
        touching=np.zeros(len(body.masses), dtype=bool),
        activations=np.zeros(0),
    )
    (patch,) = ground_patches(view, ("base",))
    ways = -np.column_stack([np.cos(EIGHTHS), np.sin(EIGHTHS)]) @ patch.frame[1:]
    sliding = np.arctan2(ways[:, 1], ways[:, 0]) - turn
    expected = np.interp(sliding, EIGHTHS, EIGHT, period=2.0 * math.pi)
    # float32 positions turn the direction by 1e-7
    np.testing.assert_allclose(patch.factors, expected, rtol=1e-5)
    if not any(slip):
        ahead = [math.cos(turn), math.sin(turn), 0.0]
        np.testing.assert_allclose(patch.frame[1], ahead, atol=1e-6)


def test_mistakes_are_one_sentence() -> None:
    with pytest.raises(InputError, match="takes 4 or 8 factors, got 3"):
        DirectionalFriction(region="base", factors=(1.0, 2.0, 3.0))
    with pytest.raises(InputError, match="finite and positive"):
        DirectionalFriction(region="base", factors=(1.0, 0.0, 1.0, 1.0))
    with pytest.raises(InputError, match="has no region 'heel'"):
        Character(
            name="a",
            mesh=box(),
            directional_friction=(DirectionalFriction(region="heel"),),
        )
