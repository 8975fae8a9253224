"""Sharp edges of the ground against faces of a body that are larger than they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

import warp_softbody as wsb
from tests.support.bodies import box
from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.body.surface_edges import SurfaceEdges
from warp_softbody.world.creases import ALONG_X, ALONG_Y, DIAGONAL, creases
from warp_softbody.world.frame import GROUND

G = 9.81
STIFF = wsb.Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.02)
RUN = 0.0125
"""m, of the grid along x."""
HEIGHT = 0.05
"""m, of the ridges, which stand on one row of the grid."""


def ridges(*places: float, friction: float = 0.5) -> wsb.HeightField:
    """Level ground with ridges across x: 50 mm high, 25 mm wide at the foot."""
    x = RUN * np.arange(-80, 81)
    heights = np.zeros_like(x)
    for place in places:
        heights[np.abs(x - place) < 0.5 * RUN] = HEIGHT
    return wsb.HeightField(
        heights=np.repeat(heights[:, None], 3, axis=1),
        spacing=(RUN, 1.0),
        origin=(-1.0, -1.0),
        friction=friction,
    )


def plate(name: str, height: float, material: wsb.Material = STIFF) -> wsb.Character:
    """0.8 x 0.4 x 0.1 m with edges of 0.2 m and longer; no node stands over x = 0.1 or -0.1."""
    mesh = box((4, 2, 1), (0.8, 0.4, 0.1), (-0.4, -0.2, 0.0))
    body = wsb.Character(name=name, mesh=mesh, material=material)
    return wsb.placed(body, translation=(0.0, 0.0, height))


def heights_over(positions: FloatArray, surface: npt.NDArray[np.int32], place: float) -> FloatArray:
    """Where edges of a surface cross the plane x = place, m."""
    ends = SurfaceEdges.of(surface).ends
    a, b = positions[ends[:, 0]], positions[ends[:, 1]]
    across = (a[:, 0] - place) * (b[:, 0] - place) < 0.0
    a, b = a[across], b[across]
    share = (place - a[:, 0]) / (b[:, 0] - a[:, 0])
    return np.asarray(a[:, 2] + share * (b[:, 2] - a[:, 2]))


def simulation(scene: wsb.Scene, **options: object) -> wsb.Simulation:
    given: dict[str, object] = {"precision": "float64", "time_step": 0.01, "sleep": False}
    return wsb.Simulation(scene, options=wsb.SimulationOptions(**given | options))  # type: ignore[arg-type]


def test_of_a_step_the_upper_edge_is_a_crease() -> None:
    heights = np.repeat(np.array([0.0, 0.0, 0.05, 0.05])[:, None], 4, axis=1)
    found = creases(heights, (0.0125, 0.5))
    expected = np.zeros((4, 4), dtype=int)
    # an edge at the rim has a face on one side alone; along y the last vertex begins none
    expected[2, :-1] = ALONG_Y
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(
        creases(heights.T.copy(), (0.5, 0.0125)), (expected.T == ALONG_Y) * ALONG_X
    )
    assert not creases(-np.abs(heights - 0.05), (0.5, 0.5)).any()


def test_creases_run_along_diagonals_too() -> None:
    x = np.arange(5.0)
    roof = -np.abs(x[:, None] - x[None, :])
    found = creases(roof, (1.0, 1.0))
    np.testing.assert_array_equal(np.diag(found)[1:-1] & DIAGONAL, DIAGONAL)
    assert not (creases(-roof, (1.0, 1.0)) & DIAGONAL).any()


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_plate_lies_on_ridges_narrower_than_its_edges(precision: str) -> None:
    scene = wsb.Scene(character=plate("plate", HEIGHT + 0.01), ground=ridges(-0.1, 0.1))
    run = simulation(scene, precision=precision)
    *_, last = run.run(1.5)
    surface = scene.character.mesh.surface
    for place in (-0.1, 0.1):
        lowest = heights_over(last.positions, surface, place).min()
        assert abs(lowest - HEIGHT) < 1e-5
    weight = G * run.model.masses.sum()
    np.testing.assert_allclose(
        last.contacts.force_on("plate"), [0.0, 0.0, weight], atol=1e-4 * weight
    )
    assert (last.contacts.partners == -1).all() and last.positions[:, 2].min() > HEIGHT - 0.01
    summary = run.summary()
    assert summary.findings.momentum_error < 1e-4
    # some steps of a landing with friction do not settle, as those of other pairs
    assert summary.unconverged_steps <= 6


def test_without_nodes_on_the_ridge_the_friction_is_coulombs() -> None:
    """A stiff plate slides along two ridges; only edges touch. It slows down by mu g."""
    friction, speed = 0.3, 1.0
    scene = wsb.Scene(
        character=plate("plate", HEIGHT, wsb.Material(young_modulus=1e8, stiffness_damping=0.02)),
        ground=ridges(-0.1, 0.1, friction=friction),
        initial_velocity=(0.0, speed, 0.0),
    )
    run = simulation(scene, time_step=0.005)
    speeds = [float((run.model.masses @ f.velocities)[1]) for f in run.run(0.2)]
    slowing = -np.diff(speeds[1:]) * run.fps / run.model.masses.sum()
    np.testing.assert_allclose(slowing, friction * G, rtol=5e-3)
    for _ in run.run(0.7):
        pass
    assert np.abs(run.state.velocities.numpy()).max() < 1e-4


def test_a_face_that_leans_forward_is_hit_by_a_riser() -> None:
    """Frictionless and without gravity: what the edge gives is what the block gains."""
    x = RUN * np.arange(-80, 81)
    heights = np.where(x > -0.5 * RUN, HEIGHT, 0.0)
    ground = wsb.HeightField(
        heights=np.repeat(heights[:, None], 3, axis=1),
        spacing=(RUN, 1.0),
        origin=(-1.0, -1.0),
        friction=0.0,
    )
    mesh = box((1, 1, 1), (0.3, 0.3, 0.3), (-0.15, -0.15, -0.15))
    body = wsb.Character(name="block", mesh=mesh, material=STIFF)
    body = wsb.placed(body, translation=(-0.2, 0.0, 0.215), axis=(0.0, 1.0, 0.0), degrees=50.0)
    scene = wsb.Scene(
        character=body, ground=ground, gravity=(0.0, 0.0, 0.0), initial_velocity=(1.0, 0.0, 0.0)
    )
    run = simulation(scene, time_step=0.005)
    masses, given, touched = run.model.masses, np.zeros(3), 0
    kinetic = 0.5 * masses.sum()
    for _ in range(60):
        run.step()
        frame = run.frame()
        given = given + run.model.options.time_step * frame.contacts.force_on("block")
        touched += len(frame.contacts.points) > 0
        energy = 0.5 * float(masses @ (frame.velocities**2).sum(axis=1))
        assert energy < kinetic * (1.0 + 1e-9)
        gaps, _ = ground.measure(frame.positions)
        assert gaps.min() > -5e-3
    gained = masses @ frame.velocities - masses.sum() * np.array([1.0, 0.0, 0.0])
    # to the tolerance of the solves
    np.testing.assert_allclose(gained, given, atol=5e-5 * masses.sum())
    assert touched > 0 and gained[0] < -0.1 * masses.sum()


def test_thrown_blocks_of_any_kind_gain_no_energy_on_steps_and_hills() -> None:
    rng = np.random.default_rng(5)
    settings = {"steps": 0.1, "roughness": 0.05, "slope": 15.0}
    unsettled = 0
    for throw in range(8):
        size = rng.uniform(0.1, 0.5, 3)
        mesh = box(tuple(rng.integers(1, 4, 3)), tuple(size), tuple(-0.5 * size))
        material = wsb.Material(young_modulus=10.0 ** rng.uniform(4.5, 7.5), stiffness_damping=0.01)
        body = wsb.Character(name="block", mesh=mesh, material=material)
        body = wsb.placed(body, axis=tuple(rng.normal(size=3)), degrees=rng.uniform(0.0, 180.0))
        ground = scenes.make("walk-x", {**settings, "ground_seed": throw}).scene.ground
        assert isinstance(ground, wsb.HeightField)
        ground = replace(ground, origin=(-2.5, -2.5), friction=rng.uniform(0.0, 1.5))
        above = float((ground.surface(body.mesh.points)[0] - body.mesh.points[:, 2]).max())
        body = wsb.placed(body, translation=(0.0, 0.0, above + 0.05))
        velocity = (*rng.uniform(-3.0, 3.0, 2), -1.0)
        scene = wsb.Scene(character=body, ground=ground, initial_velocity=velocity)
        run = simulation(scene, precision="auto", time_step=1.0 / 60.0)
        energies = [_energy(run.model.masses, frame) for frame in run.run(1.0)]
        assert max(energies) < energies[0] * (1.0 + 1e-6)
        last, summary = run.frame(), run.summary()
        assert ground.measure(last.positions)[0].min() > -5e-3
        # of a step that ends unsettled the ground's impulses are those of its last pass
        most = 1e-2 if summary.unconverged_steps else 1e-4
        assert summary.findings.momentum_error < most
        unsettled += summary.unconverged_steps
    assert unsettled < 10


def _energy(masses: FloatArray, frame: wsb.Frame) -> float:
    """Kinetic energy and that of the weight, J."""
    kinetic = 0.5 * float(masses @ (frame.velocities**2).sum(axis=1))
    return kinetic + G * float(masses @ frame.positions[:, 2])


def test_two_bodies_on_ridges_bear_each_other() -> None:
    above = wsb.Body(character=plate("above", HEIGHT + 0.1))
    scene = wsb.Scene(
        character=plate("below", HEIGHT),
        others=(above,),
        ground=ridges(-0.1, 0.1),
        body_friction=0.5,
    )
    run = simulation(scene)
    *_, last = run.run(1.0)
    weight = G * run.model.masses.sum()
    ground = last.contacts.force_on("below", by=GROUND)
    np.testing.assert_allclose(ground, [0.0, 0.0, weight], atol=1e-3 * weight)
    assert (
        heights_over(
            last.positions[: len(scene.character.mesh.points)], scene.character.mesh.surface, 0.1
        ).min()
        > HEIGHT - 1e-4
    )


def test_a_motion_on_ridges_goes_on_to_the_last_bit() -> None:
    scene = wsb.Scene(
        character=plate("plate", HEIGHT + 0.01),
        ground=ridges(-0.1, 0.1),
        initial_velocity=(0.0, 0.5, 0.0),
    )
    run = simulation(scene, precision="float32")
    for _ in range(20):
        run.step()
    saved = run.save()
    for _ in range(10):
        run.step()
    once = run.state.positions.numpy().copy()
    run.restore(saved)
    for _ in range(10):
        run.step()
    np.testing.assert_array_equal(run.state.positions.numpy(), once)


def test_smooth_ground_has_no_such_contacts() -> None:
    x = np.linspace(-1.0, 1.0, 41)
    hills = 0.05 * np.sin(4.0 * x)[:, None] * np.ones(41)
    for ground in (wsb.Plane(), wsb.HeightField(heights=hills, spacing=(0.05, 0.05))):
        scene = wsb.Scene(character=plate("plate", 0.2), ground=ground)
        assert not scene.has_ground_edges
        assert not simulation(scene).model.has_pairs


@pytest.mark.parametrize("away", [-9e8, 9e8])
def test_a_body_farther_away_than_cells_can_be_counted_meets_none(away: float) -> None:
    """Its way from the grid, in cells, is no whole number of 32 bits."""
    ground = wsb.HeightField(
        heights=np.repeat(ridges(0.1).heights[:, :1], 5, axis=1),
        spacing=(RUN, 1e-3),
        origin=(-1.0, -2e-3),
    )
    body = wsb.placed(plate("plate", 1.0), translation=(0.0, away, 0.0))
    *_, last = simulation(wsb.Scene(character=body, ground=ground)).run(0.1)
    assert not last.contacts.nodes.size


def test_a_run_goes_on_where_surfaces_touch_themselves_or_no_more() -> None:
    """Pairs with the ground come after those of surfaces, where these are."""
    apart = wsb.Scene(character=plate("plate", HEIGHT + 0.001), ground=ridges(-0.1, 0.1))
    touching = replace(apart, self_contact=True)
    level = replace(apart, ground=wsb.Plane())
    ends = []
    for scene in (apart, touching):
        first = simulation(scene)
        for _ in first.run(0.1):
            pass
        for then in (apart, touching):
            second = wsb.Simulation(then, options=first.model.options, after=first)
            second.step()
            ends.append(second.frame())
        # its pairs are gone
        wsb.Simulation(level, options=first.model.options, after=first).step()
    for end in ends[1:]:
        assert end.contacts.nodes.size
        np.testing.assert_array_equal(end.positions, ends[0].positions)
        np.testing.assert_array_equal(end.contacts.forces, ends[0].contacts.forces)
