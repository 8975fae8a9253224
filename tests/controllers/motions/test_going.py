"""Bodies that nobody prepared go where they are asked to: walking, crawling, jumping, rolling."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls
from trimesh import creation

from tests.support.surfaces import BODIES, at, joined, limb
from warp_softbody import Character, Plane, Scene, Simulation, controllers
from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.motions.for_any_body.righting import righting
from warp_softbody.controllers.motions.for_any_body.support import drawn_together, hull, nearest_in
from warp_softbody.controllers.motions.for_any_body.ways import way_to_crawl, way_to_walk
from warp_softbody.errors import InputError, MeshWarning

Walk, Crawl, Jump, Roll = (
    controllers.Walk,
    controllers.Crawl,
    controllers.Jump,
    controllers.Roll,
)


@cache
def made(name: str) -> Character:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return Character.from_surface(BODIES[name](), name=name)


def path(
    character: Character, controller: Controller, seconds: float, friction: float = 0.8
) -> FloatArray:
    """Path (f, 3) m of the centre of mass, ten places a second."""
    mesh = character.mesh
    mass = lumped_masses(mesh.tets, mesh.volumes, len(mesh.points))
    simulation = Simulation(
        Scene(character=character, ground=Plane(friction=friction)),
        controller,
        time_step=1 / 60,
        fps=10,
    )
    return np.array([mass @ f.positions / mass.sum() for f in simulation.run(seconds)])


def length(character: Character) -> float:
    return float(np.ptp(character.mesh.bounds, axis=0).max())


def test_a_caterpillar_crawls_along_its_heading() -> None:
    for heading in (0.0, np.pi):
        way = path(made("caterpillar"), Crawl.for_(made("caterpillar"), heading=heading), 4.0)
        gone = way[-1] - way[0]
        assert np.cos(heading) * gone[0] > 0.4
        assert abs(gone[1]) < 0.2


@pytest.mark.parametrize(("speed", "friction"), [(0.1, 0.8), (0.3, 0.4)])
def test_a_caterpillar_crawls_as_fast_as_it_is_asked(speed: float, friction: float) -> None:
    """Once it has started; by half of 0.1 m/s and two thirds of 0.3 where the plan waits for it."""
    body = made("caterpillar")
    way = path(body, Crawl.for_(body, speed=speed), 6.0, friction)[20:, 0]
    assert way[-1] - way[0] == pytest.approx(speed * 0.1 * (len(way) - 1), rel=0.1)


def test_a_plan_waits_for_a_body_that_is_held_back() -> None:
    """On ice it comes nowhere, and its plan is not further ahead than its leash and a stride."""
    body = made("caterpillar")
    crawl = Crawl.for_(body)
    way = path(body, crawl, 6.0, 0.0)
    assert abs(way[-1, 0] - way[0, 0]) < 0.1
    assert crawl._frame.place[0] - way[-1, 0] < 0.6 * length(body)


def test_a_table_walks_as_fast_as_it_is_asked() -> None:
    body = made("table")
    slow, fast = (path(body, Walk.for_(body, speed=speed), 5.0) for speed in (0.1, 0.25))
    assert 0.2 < slow[-1, 0] - slow[0, 0] < 0.6
    assert fast[-1, 0] - fast[0, 0] > 1.5 * (slow[-1, 0] - slow[0, 0])
    assert fast[:, 2].min() > 0.9 * fast[0, 2]


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["caterpillar", "table", "quadruped", "chair", "starfish", "letter_y", "torus"]
)
def test_travels_its_length(name: str) -> None:
    body = made(name)
    motion = Crawl if name == "caterpillar" else Walk
    way = path(body, motion.for_(body), 12.0)
    assert way[-1, 0] - way[0, 0] > length(body)
    assert abs(way[-1, 1] - way[0, 1]) < 0.5 * length(body)
    assert way[:, 2].min() > 0.75 * way[0, 2]


@pytest.mark.parametrize("tets", [800, 3000])
def test_a_starfish_goes_on_any_mesh_of_it(tets: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        body = Character.from_surface(BODIES["starfish"](), name="starfish", tets=tets)
    way = path(body, Walk.for_(body), 2.0)
    assert way[-1, 0] - way[0, 0] > 0.1 * length(body)
    assert abs(way[-1, 1] - way[0, 1]) < 0.05 * length(body)


@pytest.mark.parametrize("count", [3, 6])
def test_other_numbers_of_feet(count: int) -> None:
    """A stool on three legs and a table on six, which nothing was tuned for."""
    angles = 2.0 * np.pi * np.arange(count) / count
    ways = [(float(np.cos(angle)), float(np.sin(angle))) for angle in angles]
    legs = (limb((0.2 * x, 0.2 * y, 0.5), (0.28 * x, 0.28 * y, 0.06), 0.06) for x, y in ways)
    seat = at(creation.cylinder(0.3, 0.1), (0.0, 0.0, 0.55))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        body = Character.from_surface(joined(seat, *legs), name="stool", tets=1200)
    way = path(body, Walk.for_(body, heading=1.0), 4.0)
    gone = way[-1] - way[0]
    assert gone[0] * np.cos(1.0) + gone[1] * np.sin(1.0) > 0.4 * length(body)
    assert way[:, 2].min() > 0.8 * way[0, 2]


def test_a_ring_rolls() -> None:
    body = made("torus")
    way = path(body, Roll.for_(body), 2.0)
    assert way[-1, 0] - way[0, 0] > 0.4 * length(body)
    assert way[:, 2].min() > 0.9 * way[0, 2]


def test_a_narrow_ring_is_steered_below_its_lean() -> None:
    """One with a flat rim of a fifth of its height; it fell at 1.35 m where it was not steered."""
    ring = creation.annulus(0.25, 0.5, 0.2, sections=48)
    # its axle, which is along z, along y
    ring.apply_transform(np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]))
    body = Character.from_surface(ring, name="ring")
    way = path(body, Roll.for_(body), 4.2)
    assert way[-1, 0] - way[0, 0] > 1.8
    assert abs(way[-1, 1] - way[0, 1]) < 0.6
    assert way[:, 2].min() > 0.9 * way[0, 2]


@pytest.mark.long
@pytest.mark.parametrize("name", ["table", "mushroom", "letter_y", "chair"])
def test_jumps(name: str) -> None:
    body = made(name)
    scene = Scene(character=body, ground=Plane())
    simulation = Simulation(scene, Jump.for_(body, height=0.08), time_step=1 / 60)
    *frames, last = simulation.run(3.0)
    assert 0.04 < max(frame.positions[:, 2].min() for frame in frames) < 0.15
    assert abs(last.velocities).max() < 0.2


def test_feet_across_from_each_other_step_together() -> None:
    walk = way_to_walk(made("table"))
    points = made("table").mesh.points
    assert [len(turn) for turn in walk.turns] == [2, 2]
    for turn in walk.turns:
        one, other = (points[walk.feet[foot], :2].mean(axis=0) for foot in turn)
        np.testing.assert_allclose(one, -other, atol=0.05)
    assert sorted(foot for turn in way_to_walk(made("starfish")).turns for foot in turn) == [
        *range(5)
    ]
    # on one sole, its quadrants
    assert len(way_to_walk(made("mushroom")).feet) == 4


def test_sections_of_a_belly_are_in_order_along_the_heading() -> None:
    body = made("caterpillar")
    sections = way_to_crawl(body, np.pi).feet
    places = [body.mesh.points[section, 0].mean() for section in sections]
    assert (np.diff(places) < 0.0).all()


def test_what_lacks_is_told() -> None:
    table, fish, worm = made("table"), made("starfish"), made("caterpillar")
    with pytest.raises(InputError, match="Crawl needs a body that lies"):
        Crawl.for_(table)
    with pytest.raises(InputError, match="2 times as long along its heading"):
        Crawl.for_(worm, heading=np.pi / 2)
    with pytest.raises(InputError, match="Jump needs a body that stands"):
        Jump.for_(fish)
    with pytest.raises(InputError, match="Roll needs nodes in the region 'rim'"):
        Roll.for_(table)
    with pytest.raises(InputError, match="Walk needs muscles"):
        Walk.for_(replace(table, muscles=()))
    with pytest.raises(InputError, match="Walk needs nodes in the region 'base'"):
        Walk.for_(replace(table, regions={}))
    with pytest.raises(InputError, match=r"speed of Walk must be .* from 0 to"):
        Walk.for_(table, speed=9.0)
    # no further a cycle than any body that lies was found to reach
    with pytest.raises(InputError, match=r"speed of Crawl must be .* from 0 to 0.307"):
        Crawl.for_(worm, speed=0.4)
    with pytest.raises(InputError, match="height of Jump"):
        Jump.for_(table, height=-1.0)


@given(
    st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=1, max_size=9),
    st.tuples(st.integers(-20, 20), st.integers(-20, 20)),
)
def test_the_nearest_point_of_an_area(
    corners: list[tuple[int, int]], point: tuple[int, int]
) -> None:
    """As non-negative least squares over the weights of all points finds it."""
    places, goal = np.array(corners, float), np.array(point, float)
    found = nearest_in(hull(places), goal)
    sum_of_weights = 1e4 * np.ones(len(places))
    weights, _ = nnls(np.vstack([places.T, sum_of_weights]), np.append(goal, 1e4))
    best = float(np.linalg.norm(weights @ places - goal))
    assert float(np.linalg.norm(found - goal)) <= best + 1e-4
    # and it lies in the area: no side has it outside
    corners_found = hull(places)
    if len(corners_found) > 2:
        sides = np.roll(corners_found, -1, axis=0) - corners_found
        inward = (
            sides[:, 0] * (found - corners_found)[:, 1]
            - sides[:, 1] * (found - corners_found)[:, 0]
        )
        assert inward.min() > -1e-9 * 400.0


def test_an_area_is_drawn_together_to_its_middle() -> None:
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    np.testing.assert_allclose(drawn_together(square, 0.5), 0.5 + 0.5 * square)


def test_a_turned_body_is_brought_back() -> None:
    """Of a small turn about an axis the rate is minus the moment of inertia times it."""
    body = made("table")
    view = Simulation(Scene(character=body, ground=Plane())).view()
    arms = view.positions - view.center_of_mass
    moments = (view.masses[:, None] * arms).T @ arms
    for axis in range(3):
        turn = np.zeros(3)
        turn[axis] = 1e-4
        moved = replace(view, positions=view.positions + np.cross(turn, arms))
        wanted = -2.0 * (np.trace(moments) * np.eye(3) - moments) @ turn
        np.testing.assert_allclose(righting(moved, 2.0, 1.0), wanted, atol=1e-8 * np.trace(moments))
