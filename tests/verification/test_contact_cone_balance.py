"""Friction cones of four and eight directions: balances, energy, precisions, options, runs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.linear.matrices import NORMAL, assembled, factor_of, preconditioned
from tests.support.bodies import Rig, box
from tests.verification.dropped_cube import G, cube, energy
from tests.verification.scaly_slab import scaly_slab
from warp_softbody.cli import main
from warp_softbody.contact_mode import ContactMode
from warp_softbody.engine.options import Cone, Precision, SimulationOptions
from warp_softbody.errors import InputError
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.linear.preconditioner import TwoLevel, WarpedFactor
from warp_softbody.run.simulation import Simulation
from warp_softbody.stage_exports import measure, read_take
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

POLYGONS: tuple[Cone, ...] = ("4", "8")


@pytest.mark.parametrize("two_levels", [False, True])
def test_preconditioners_know_nodes_that_are_free_along_a_line(two_levels: bool) -> None:
    """Symmetric, positive, and nothing on what is given; the factor is the inverse itself."""
    mesh = box((3, 3, 4), (0.3, 0.3, 0.4), jitter=0.2)
    choice = "two_level" if two_levels else "factor"
    body, matrix = assembled(mesh, precision="float64", preconditioner=choice)
    n = len(mesh.points)
    kinds = np.random.default_rng(4).integers(0, 4, n)
    planes = np.linalg.svd(NORMAL[None])[2][1:]
    kept = {
        VelocityConstraint.NONE: np.eye(3),
        VelocityConstraint.PLANE: planes,
        VelocityConstraint.FIXED: np.zeros((0, 3)),
        VelocityConstraint.LINE: NORMAL[None],
    }
    basis = np.concatenate(
        [np.kron(np.eye(n)[i], kept[VelocityConstraint(kinds[i])]) for i in range(n)]
    ).T
    preconditioner = factor_of(body, kinds)
    assert isinstance(preconditioner, TwoLevel if two_levels else WarpedFactor)
    applied = preconditioned(body, preconditioner, basis)
    np.testing.assert_allclose(
        basis @ (basis.T @ applied), applied, atol=1e-12 * np.abs(applied).max()
    )
    inside = basis.T @ applied
    np.testing.assert_allclose(inside, inside.T, atol=1e-12 * np.abs(inside).max())
    assert np.linalg.eigvalsh(0.5 * (inside + inside.T)).min() > 0.0
    if not two_levels:
        expected = np.linalg.inv(basis.T @ matrix @ basis)
        np.testing.assert_allclose(inside, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("cone", POLYGONS)
@pytest.mark.parametrize("cells", [4, 8], ids=["factor", "two levels"])
def test_momentum_changes_by_weight_and_contact_alone(cone: Cone, cells: int) -> None:
    """In every step of a landing and a slide, to the residual of the solves."""
    body = cube(0.02, 1e5, 0.02, 0.01, cells=cells, cone=cone, precision="float64", tolerance=1e-10)
    assert (body.model.system.coarse is not None) == (cells == 8)
    body.place(velocities=(0.8, 0.5, 0.0))
    weight = body.masses.sum() * G * 0.01
    seen = set()
    for _ in range(40):
        before = body.momentum
        assert body.step().contact_converged
        impulses = body.contacts.impulses.numpy().sum(axis=0)
        np.testing.assert_allclose(
            body.momentum - before, impulses - [0.0, 0.0, weight], atol=1e-6 * weight
        )
        seen |= set(body.contacts.modes.numpy().tolist())
    # corners and edges both occur
    assert {mode % 2 for mode in seen if mode > ContactMode.SLIDE} == {0, 1}


@pytest.mark.parametrize("cone", POLYGONS)
@pytest.mark.parametrize("young_modulus", [1e5, 1e7])
def test_no_step_gains_energy(young_modulus: float, cone: Cone) -> None:
    """As on the smooth cone: by no more than what float32 positions hide, thrown from 0.3 m."""
    body = cube(0.3, young_modulus, 0.005, 1 / 120, cone=cone)
    body.place(velocities=(2.0, 0.7, 0.0))
    rounding = 100 * 6e-8 * body.masses.sum() * G
    last = energy(body)
    for _ in range(150):
        body.step()
        now = energy(body)
        assert now < last + rounding
        last = now
    assert body.positions[:, 2].min() > -1e-4


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("cone", POLYGONS)
def test_at_rest_the_laws_hold_and_the_weight_is_carried(cone: Cone, precision: Precision) -> None:
    body = cube(0.05, 1e5, 0.02, 0.01, cone=cone, precision=precision)
    body.place(velocities=(1.0, 0.3, 0.0))
    unsettled = sum(not body.step().contact_converged for _ in range(250))
    assert unsettled == 0
    assert np.linalg.norm(body.velocities, axis=1).max() < 1e-4
    weight = body.masses.sum() * G * 0.01
    normal = body.contacts.impulses.numpy().astype(np.float64)[:, 2].sum()
    assert normal == pytest.approx(weight, rel=1e-4)
    statistics = body.step()
    assert statistics.passes == 1
    assert max(statistics.signorini, statistics.coulomb) < 1e-2 * weight / 0.01


@pytest.mark.parametrize("cone", POLYGONS)
def test_the_same_run_gives_the_same_bits_and_precisions_agree(cone: Cone) -> None:
    """Positions of both precisions after a slide of 0.1 m, by a hundredth of it."""
    ends = []
    for precision in ("float32", "float32", "float64"):
        body = cube(0.05, 1e5, 0.02, 0.01, cone=cone, precision=precision)
        body.place(velocities=(1.0, 0.3, 0.0))
        body.step(100)
        ends.append(body.positions)
    np.testing.assert_array_equal(ends[0], ends[1])
    np.testing.assert_allclose(ends[0], ends[2], atol=1e-3)


@pytest.mark.parametrize("cone", POLYGONS)
def test_newton_iterations_settle_too(cone: Cone) -> None:
    body = cube(0.0, 1e5, 0.02, 0.01, cone=cone, newton_iterations=3)
    body.place(velocities=(0.5, 0.2, 0.0))
    assert all(body.step().contact_converged for _ in range(60))
    assert np.abs(body.velocities).max() < 0.02


def landed(cone: Cone) -> Rig:
    body = cube(0.05, 1e5, 0.02, 0.01, cone=cone)
    body.place(velocities=(1.0, 0.0, 0.0))
    body.step(200)
    return body


def test_along_a_direction_a_landing_ends_where_the_smooth_cone_s_does() -> None:
    """Friction along x is the same; of sideways friction, at most 8 % differ."""
    way = landed("smooth").center[0]
    for cone in POLYGONS:
        body = landed(cone)
        assert body.center[0] == pytest.approx(way, rel=1.0 - math.cos(math.pi / 8))
        assert abs(body.center[1]) < 1e-3


def test_frames_say_slide_for_every_place_of_a_polygon() -> None:
    body = landed("8")
    scene = Scene(
        character=body.model.body, ground=Plane(friction=0.5), initial_velocity=(1.0, 0.3, -1.0)
    )
    simulation = Simulation(scene, options=SimulationOptions(time_step=0.01, cone="8"))
    modes = {int(m) for frame in simulation.run(0.5) for m in frame.contacts.modes}
    assert ContactMode.SLIDE in modes and modes <= {ContactMode.STICK, ContactMode.SLIDE}


def test_mistakes_are_one_sentence() -> None:
    with pytest.raises(InputError, match="cone must be one of smooth, 4, 8, not '6'"):
        SimulationOptions(cone="6")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="directional friction needs the smooth cone"):
        scaly_slab(cone="8")


def test_letter_i_keeps_its_balance_on_eight_directions(tmp_path: Path) -> None:
    """The push that the scene comes with, measured from its stage."""
    stage = tmp_path / "i.usdc"
    assert main(["run", "balance-i", "--cone", "8", "--out", str(stage), "--quiet"]) == 0
    measures = measure(read_take(stage))
    assert measures.finite.all()
    assert measures.tilt.max() > 10.0
    assert measures.tilt[-1] < 5.0
