"""Moments on the wire: read back by other code, off by half a cell at most."""

from __future__ import annotations

import json

import numpy as np
import pytest

import warp_softbody as wsb
from tests.live.messages import read_update
from warp_softbody.live.grid import CELLS, ROOM, MovingGrid
from warp_softbody.live.scene_view import SceneView
from warp_softbody.live.wire import ON_GROUND, Moment, UpdateEncoder, as_text
from warp_softbody.world.frame import ContactSample


def view_of(name: str = "balance-i") -> tuple[SceneView, wsb.Frame]:
    plan = wsb.scenes.make(name)
    simulation = wsb.Simulation(plan.scene, time_step=plan.time_step)
    simulation.step()
    return SceneView(plan.scene, name=name, fps=30.0), simulation.frame()


def test_an_update_tells_the_frame() -> None:
    view, frame = view_of()
    outline = json.loads(as_text(view.outline.as_json()))
    encoder = UpdateEncoder(view.outline.points, differences=False)
    told = read_update(encoder.encode(view.moment(frame)), outline)
    wanted = np.concatenate([frame.positions[view.nodes], frame.fiber_points])
    # half a cell, and rounding of origin and scale to single precision
    np.testing.assert_allclose(told.places, wanted, atol=0.5 * told.scale * 1.001 + 1e-7)
    assert told.time == frame.time and told.scale < 3e-5
    np.testing.assert_allclose(told.contacts[:, :3], frame.contacts.points, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(told.contacts[:, 3:], frame.contacts.forces, rtol=1e-6, atol=1e-4)
    assert told.modes == (frame.contacts.modes + ON_GROUND).tolist() and len(told.modes) > 3
    np.testing.assert_allclose(told.contraction, 1.0 - frame.activations, atol=1 / 1020 + 1e-9)


def test_its_numbers_are_those_of_the_body() -> None:
    """Mass, centre and momenta by sums over the model's nodes, the capture point by its formula."""
    plan = wsb.scenes.make("balance-i")
    simulation = wsb.Simulation(plan.scene, time_step=plan.time_step)
    simulation.apply_force("head", (100.0, 50.0, 0.0))
    for _ in range(5):
        simulation.step()
    frame, masses = simulation.frame(), simulation.model.masses
    view = SceneView(plan.scene, name="balance-i", fps=30.0)
    names = view.outline.numbers
    numbers = dict(zip(names, view.moment(frame).numbers.tolist(), strict=True))

    def vector(name: str) -> list[float]:
        return [numbers[f"{name}.{axis}"] for axis in "xyz"]

    center = masses @ frame.positions / masses.sum()
    momentum = masses @ frame.velocities
    spin = np.cross(frame.positions - center, masses[:, None] * frame.velocities).sum(axis=0)
    np.testing.assert_allclose(vector("com"), center, rtol=1e-12)
    np.testing.assert_allclose(vector("momentum"), momentum, rtol=1e-9)
    np.testing.assert_allclose(vector("spin"), spin, rtol=1e-6, atol=1e-9)
    velocity = momentum / masses.sum()
    ahead = velocity[:2] * np.sqrt(center[2] / 9.81)
    np.testing.assert_allclose(vector("capture"), [*(center[:2] + ahead), 0.0], atol=1e-12)
    assert numbers["support"] == pytest.approx(frame.contacts.forces[:, 2].sum())


def test_uneven_ground_has_no_capture_point() -> None:
    view, frame = view_of("stairs")
    numbers = dict(zip(view.outline.numbers, view.moment(frame).numbers.tolist(), strict=True))
    assert np.isnan(numbers["capture.x"]) and np.isfinite(numbers["com.x"])


def test_updates_of_a_take_are_differences() -> None:
    view, frame = view_of()
    outline = json.loads(as_text(view.outline.as_json()))
    encoder = UpdateEncoder(view.outline.points, differences=True)
    moment = view.moment(frame)
    first = read_update(encoder.encode(moment), outline)
    again = encoder.encode(moment)
    assert not any(again[-6 * len(first.cells) :])
    second = read_update(again, outline, first)
    np.testing.assert_array_equal(second.places, first.places)


@pytest.mark.parametrize("factor", [1.0, 10.0, 1e4])
def test_a_grid_grows_with_the_body(factor: float) -> None:
    """What fits keeps the cell; what does not gets one that is as small as powers of two allow."""
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (50, 3))
    grid = MovingGrid(points)
    small = grid.scale
    assert small == pytest.approx(ROOM * np.ptp(points, axis=0).max() / CELLS)
    origin, cells = grid.place(factor * points + 3.0)
    np.testing.assert_allclose(
        origin + grid.scale * cells, factor * points + 3.0, atol=0.5001 * grid.scale
    )
    if factor == 1.0:
        assert grid.scale == small
    else:
        assert factor / ROOM * small <= grid.scale <= 2.1 * factor * small


def test_no_bodies_points_and_many_contacts() -> None:
    encoder = UpdateEncoder(np.zeros((1, 3)), differences=False)
    count = 70_000
    crowd = ContactSample(
        nodes=np.zeros(count, dtype=np.int32),
        points=np.zeros((count, 3)),
        modes=np.ones(count, dtype=np.int32),
        forces=np.zeros((count, 3)),
    )
    moment = Moment(
        time=1.0,
        surface=np.zeros((1, 3)),
        fibers=np.zeros((0, 3)),
        contraction=np.zeros(0),
        numbers=np.zeros(0),
        contacts=crowd,
    )
    outline = {"numbers": [], "segments": [], "points": 1, "fiberPoints": 0}
    assert len(read_update(encoder.encode(moment), outline).contacts) == 4096


@pytest.mark.parametrize("name", wsb.scenes.names())
def test_every_scene_has_an_outline(name: str) -> None:
    """Corners name shown points, faces name corners, and an update is a few kilobytes."""
    plan = wsb.scenes.make(name)
    view = SceneView(plan.scene, name=name, fps=30.0)
    outline = json.loads(as_text(view.outline.as_json()))
    faces = 0
    for body in outline["bodies"]:
        assert max(body["faces"]) < len(body["corners"])
        assert max(body["corners"]) < outline["points"]
        faces += len(body["faces"])
    assert faces == 3 * len(plan.scene.whole.mesh.surface)
    assert max(outline["segments"], default=-1) < max(1, outline["fiberPoints"])
    assert 6 * (outline["points"] + outline["fiberPoints"]) < 12_000
