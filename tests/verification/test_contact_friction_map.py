"""Friction given by place: Coulomb's law with the coefficient of where each node is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import Rig, Vector, box
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.contact_mode import ContactMode
from warp_softbody.engine.model import build_model
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError
from warp_softbody.world.friction_map import FrictionMap
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround

G = 9.81
STEP = 0.005
STRIPES = FrictionMap.stripes([1.0, 0.25], width=0.5, start=0.0)
FLAT = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.02)


def sliding(ground: Ground, velocity: Vector, precision: str = "float64") -> Rig:
    """A flat slab, 0.2 m long, that begins left of x = 0.1."""
    mesh = box((4, 3, 1), (0.2, 0.15, 0.03), (-0.1, -0.075, 0.0))
    character = Character(name="slab", mesh=mesh, material=FLAT)
    scene = Scene(character=character, ground=ground, initial_velocity=velocity)
    given: dict[str, Any] = {"time_step": STEP, "precision": precision}
    model = build_model(scene, SimulationOptions(**given))
    return Rig(
        model=model,
        stepper=Stepper(model),
        state=State.at_rest(model),
        after=State.at_rest(model),
        control=Control.slack(model),
        contacts=Contacts.none(model),
    )


def grounds(friction: float, placed: FrictionMap | None) -> list[Ground]:
    corners = np.array([[-4.0, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return [
        Plane(friction=friction, friction_map=placed),
        HeightField(heights=np.zeros((3, 3)), friction=friction, friction_map=placed),
        TriangleGround(vertices=corners, faces=faces, friction=friction, friction_map=placed),
    ]


def test_cells_and_what_is_beyond_them() -> None:
    placed = FrictionMap(
        factors=np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), spacing=(0.5, 1.0), origin=(1.0, -1.0)
    )
    points = np.array(
        [[1.0, -1.0, 9.0], [1.49, 0.0, 0.0], [1.5, 1.5, 0.0], [-9.0, 99.0, 0.0], [1e300, -5.0, 0.0]]
    )
    np.testing.assert_array_equal(placed.at(points), [1.0, 2.0, 6.0, 3.0, 4.0])
    assert FrictionMap.stripes([0.5, 2.0], 0.25, -1.0) == FrictionMap(
        factors=np.array([[0.5], [2.0]]), spacing=(0.25, 1.0), origin=(-1.0, 0.0)
    )


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("kind", range(3))
def test_a_map_of_one_factor_is_that_friction_to_the_bit(kind: int, precision: str) -> None:
    plain = sliding(grounds(0.5, None)[kind], (0.6, 0.2, 0.0), precision)
    placed = sliding(
        grounds(0.25, FrictionMap(factors=np.array([[2.0]])))[kind], (0.6, 0.2, 0.0), precision
    )
    for rig in (plain, placed):
        rig.step(30)
    np.testing.assert_array_equal(placed.positions, plain.positions)


def test_a_slab_is_braked_by_the_stripe_that_it_is_on() -> None:
    """dv/dt = -mu g where all of it is on one stripe, and in between where it is on both."""
    friction = 0.4
    rig = sliding(Plane(friction=friction, friction_map=STRIPES), (2.5, 0.0, 0.0))
    mass, rows = rig.masses.sum(), []
    for _ in range(100):
        x = rig.positions[:, 0]
        before = rig.momentum[0] / mass
        rig.step(1)
        rows.append((x.min(), x.max(), (before - rig.momentum[0] / mass) / STEP / G))
    left, right, braked = np.array(rows)[10:].T
    first, second = right < 0.5, left >= 0.5
    assert first.sum() > 10 and second.sum() > 10
    # by sums over the stripes: the slab rocks a little
    assert braked[first].mean() == pytest.approx(friction, rel=0.01)
    assert braked[second].mean() == pytest.approx(0.25 * friction, rel=0.02)
    between = braked[~first & ~second]
    assert 0.25 * friction < between.mean() < friction


def test_every_node_keeps_to_coulomb_s_law_of_its_place() -> None:
    """|f_t| is the bound where a node slides, by the place where it begins the step."""
    friction = 0.4
    rig = sliding(Plane(friction=friction, friction_map=STRIPES), (2.5, 0.3, 0.0))
    nodes = rig.model.body.mesh.surface_nodes
    seen = set()
    for _ in range(60):
        factors = STRIPES.at(rig.positions[nodes])
        rig.step(1)
        impulses = np.asarray(rig.contacts.impulses.numpy(), dtype=float)
        slides = rig.contacts.modes.numpy() == int(ContactMode.SLIDE)
        bound = friction * factors * impulses[:, 2]
        tangent = np.hypot(impulses[:, 0], impulses[:, 1])
        loaded = slides & (bound > 0.01 * bound.max())
        np.testing.assert_allclose(tangent[loaded], bound[loaded], rtol=0.05)
        seen |= set(factors[loaded].tolist())
    assert seen == {1.0, 0.25}


@pytest.mark.parametrize(("factor", "stays"), [(1.0, True), (0.25, False)])
def test_on_a_slope_it_stays_where_it_is_rough_and_slides_where_it_is_smooth(
    factor: float, stays: bool
) -> None:
    """By (sin - mu cos) g, along a slope of 15 degrees."""
    sine, cosine = np.sin(np.radians(15.0)), np.cos(np.radians(15.0))
    normal = (-sine, 0.0, cosine)
    placed = FrictionMap.stripes([factor, 1.0 - factor], width=50.0, start=-40.0)
    rig = sliding(Plane(friction=0.5, normal=normal, friction_map=placed), (0.0, 0.0, 0.0))
    turn = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    rig.place(rig.positions @ turn.T)
    rig.step(60)
    speed = -rig.momentum @ np.array([cosine, 0.0, sine]) / rig.masses.sum()
    expected = 0.0 if stays else (sine - 0.5 * factor * cosine) * G * 60 * STEP
    assert speed == pytest.approx(expected, rel=0.01, abs=1e-3)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"factors": [[-0.5]]}, "FrictionMap.factors must not be negative, the least is -0.5"),
        ({"factors": np.zeros((0, 2))}, "FrictionMap.factors must hold a row and a column"),
        ({"factors": [1.0]}, "FrictionMap.factors must"),
        ({"factors": [[1.0]], "spacing": (0.0, 1.0)}, "FrictionMap.spacing must be positive"),
    ],
)
def test_what_is_no_map_is_refused(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        FrictionMap(**given)
    with pytest.raises(InputError, match=r"Plane.friction_map must be"):
        Plane(friction_map=0.5)  # type: ignore[arg-type]
