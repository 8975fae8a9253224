"""Contact problems where methods fail: redundant contacts, extreme friction, sizes, units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.contact_problems import repeated, soft_body
from warp_softbody.controllers import (
    ContactQPCC,
    QPCCStatus,
    SolverOptions,
    enumerate_qpcc,
    solve_qpcc,
    solve_static,
    to_general,
)
from warp_softbody.controllers.qp.daqp import DAQPSolver
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC
from warp_softbody.errors import InputError

SHORT = SolverOptions(max_qps=60, kicks=6)


@pytest.mark.parametrize("seed", range(3))
def test_redundant_contacts_give_consistent_points(seed: int) -> None:
    single = soft_body(seed, contacts=2, controls=8, directions=4)
    best = enumerate_qpcc(single).objective
    result = solve_qpcc(repeated(single, [0, 0, 1, 1, 1]), options=SHORT)
    assert result.status is not QPCCStatus.INACCURATE
    assert result.complementarity < 1e-8 and result.qp_count <= 60
    # The copies may share a load but gain nothing by it.
    assert result.objective >= best - 1e-6 * (1.0 + abs(best))


def rigid_block(contacts: int, copies: int = 0, *, pull: float = 0.0) -> ContactQPCC:
    """A rigid block of 3 kg on points of its lower face, pulled along x through its contact plane.

    Its one control pushes along y, with an effort that keeps it at zero. Of the points, ``copies``
    stand on the first ones. The mobility J M^-1 J' has rank 6 or less.
    """
    mass, inertia, gravity_impulse = 3.0, np.array([0.02, 0.03, 0.04]), 3.0 * 9.81 * 0.01
    angles = 2.0 * np.pi * np.arange(contacts) / (contacts - copies)
    points = np.stack([0.2 * np.cos(angles), 0.2 * np.sin(angles), np.full(contacts, -0.1)], axis=1)
    jacobian = []
    for point in points:
        turning = -np.cross(np.eye(3), point)
        # w x p along each axis; local order normal, tangent 1, tangent 2.
        jacobian.append(np.hstack([np.eye(3), turning.T])[[2, 0, 1]])
    rows = np.concatenate(jacobian)
    inverse = np.diag(np.r_[np.full(3, 1.0 / mass), 1.0 / inertia])
    push = np.array([0.0, 1.0, 0.0, 0.1, 0.0, 0.0])
    # A pull at the height of the contacts has no moment about them: arm (0, 0, -0.1).
    impulse = np.array([pull, 0.0, -gravity_impulse, 0.0, -0.1 * pull, 0.0])
    hessian = np.zeros((1 + 3 * contacts,) * 2)
    hessian[0, 0] = 1.0
    return ContactQPCC(
        hessian=hessian,
        gradient=np.zeros(len(hessian)),
        lower=np.full(1, -1.0),
        upper=np.full(1, 1.0),
        velocity_offset=rows @ inverse @ impulse,
        velocity_from_controls=(rows @ inverse @ push)[:, None],
        velocity_from_forces=rows @ inverse @ rows.T,
        friction=np.full(contacts, 0.5),
    )


@pytest.mark.parametrize(("contacts", "copies"), [(3, 0), (4, 0), (6, 0), (8, 0), (6, 3), (8, 4)])
@pytest.mark.parametrize("share", [0.9, 1.5])
def test_a_rigid_block_on_many_points_obeys_coulomb_as_a_whole(
    contacts: int, copies: int, share: float
) -> None:
    weight = 3.0 * 9.81 * 0.01
    limit = 0.5 * weight
    problem = rigid_block(contacts, copies, pull=share * limit)
    for result in (solve_qpcc(problem, budget=60), solve_static(problem)):
        assert result.status not in (QPCCStatus.INACCURATE, QPCCStatus.NO_POINT)
        # The tolerance of the solver on every scaled pair, and some units in the last place.
        assert result.complementarity < 1e-8
        total = result.forces.sum(axis=0)
        np.testing.assert_allclose(total[0], weight, rtol=1e-7)
        # Held below the limit; beyond it all points slide along x under full friction.
        np.testing.assert_allclose(total[1], -min(share, 1.0) * limit, rtol=1e-7)
        speed = max(share - 1.0, 0.0) * limit / 3.0
        np.testing.assert_allclose(result.velocities[:, 1], speed, atol=1e-9)
        np.testing.assert_allclose(result.velocities[:, [0, 2]], 0.0, atol=1e-9)
    best = solve_qpcc(problem, budget=60)
    again = solve_qpcc(problem, start=best.modes)
    assert again.objective <= best.objective + 1e-9


@pytest.mark.parametrize("friction", [0.0, 1e-12, 10.0])
def test_extreme_friction_against_enumeration(friction: float) -> None:
    for seed in range(4):
        problem = replace(
            soft_body(seed, contacts=2, controls=6, directions=4), friction=np.full(2, friction)
        )
        result, reference = solve_qpcc(problem, budget=200), enumerate_qpcc(problem)
        assert result.complementarity < 1e-8
        np.testing.assert_allclose(result.objective, reference.objective, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("friction", [1e-8, 1e-6, 1e-4])
def test_slim_cones_let_no_contact_pull(friction: float) -> None:
    """Little friction changes little, and least of all the sign of a normal force."""
    for seed in range(6):
        plain = soft_body(seed, contacts=2, controls=6, directions=4)
        none = enumerate_qpcc(replace(plain, friction=np.zeros(2)))
        problem = replace(plain, friction=np.full(2, friction))
        for found in (enumerate_qpcc(problem), solve_qpcc(problem)):
            assert found.status is not QPCCStatus.INACCURATE and found.complementarity < 1e-8
            assert found.forces[:, 0].min() >= -1e-8 * problem.scales[1]
        least = enumerate_qpcc(problem).objective
        np.testing.assert_allclose(least, none.objective, atol=1e3 * friction + 1e-7, rtol=1e-6)


def test_a_contact_that_nothing_opens_is_infeasible_at_once() -> None:
    for contacts in (1, 2, 8):
        plain = soft_body(1, contacts=contacts, controls=6, directions=4)
        falling = plain.velocity_offset.copy()
        falling[0] = -1e3
        held = plain.velocity_from_forces.copy()
        held[:3], held[:, :3] = 0.0, 0.0
        stuck = replace(plain, velocity_offset=falling, velocity_from_forces=held)
        for start in (None, (1,) * contacts):
            found = solve_qpcc(stuck, start=start)
            assert found.status is QPCCStatus.INFEASIBLE and found.qp_count <= 4
        if contacts <= 2:
            assert enumerate_qpcc(stuck).status is QPCCStatus.INFEASIBLE


def test_a_singular_objective_gives_consistent_points() -> None:
    for seed in range(4):
        problem = soft_body(seed, contacts=2, controls=30, directions=4)
        slopes = problem.hessian - np.diag(np.r_[np.full(30, 1e-2), np.zeros(6)])
        singular = replace(problem, hessian=0.5 * (slopes + slopes.T))
        result = solve_qpcc(singular, options=SHORT)
        assert result.complementarity < 1e-8
        assert result.objective >= enumerate_qpcc(singular).objective - 1e-6


def test_without_any_objective_a_consistent_point_comes_back() -> None:
    plain = soft_body(0, contacts=3, controls=6)
    nothing = replace(plain, hessian=np.zeros((15, 15)), gradient=np.zeros(15), constant=0.0)
    result = solve_qpcc(nothing, options=SHORT)
    assert result.objective == 0.0 and result.complementarity < 1e-8


@pytest.mark.parametrize("contacts", [0, 60])
def test_no_contacts_and_sixty(contacts: int) -> None:
    problem = soft_body(0, contacts=contacts, controls=20)
    result = solve_qpcc(problem, start=(1,) * contacts, budget=20)
    assert result.qp_count <= 20 and result.complementarity < 1e-8
    assert result.status is not QPCCStatus.INACCURATE


@pytest.mark.parametrize("exponent", [-8, 8])
def test_badly_scaled_contacts(exponent: int) -> None:
    """One contact's mobility is 1e8 times smaller or larger than its neighbour's."""
    plain = soft_body(2, contacts=2, controls=6, directions=4)
    size = np.r_[np.ones(3), np.full(3, 10.0 ** (0.5 * exponent))]
    scaled = replace(
        plain,
        velocity_offset=plain.velocity_offset * size,
        velocity_from_controls=plain.velocity_from_controls * size[:, None],
        velocity_from_forces=plain.velocity_from_forces * size[:, None] * size,
    )
    result = solve_qpcc(scaled, budget=60)
    consistent = result.complementarity < 1e-8
    assert consistent or result.status in {QPCCStatus.INACCURATE, QPCCStatus.NO_POINT}


def test_both_forms_find_the_same_minimum() -> None:
    for seed in range(4):
        problem = soft_body(seed, contacts=2, controls=6, directions=4)
        best = enumerate_qpcc(problem).objective
        general = to_general(problem)
        result = solve_qpcc(general)
        np.testing.assert_allclose(result.objective, best, rtol=1e-5, atol=1e-7)
        contact = solve_qpcc(problem)
        assert general.complementarity(contact.x) < 1e-8
        np.testing.assert_allclose(general.objective(contact.x), contact.objective, rtol=1e-9)


def test_a_cold_start_is_seldom_worse_than_a_kicked_one() -> None:
    problems = [soft_body(seed, contacts=6, controls=24, directions=4) for seed in range(4)]
    cold = np.array([solve_qpcc(problem).objective for problem in problems])
    kicked = np.array([solve_qpcc(problem, options=SHORT).objective for problem in problems])
    assert np.count_nonzero(cold <= kicked + 1e-6 * (1.0 + np.abs(kicked))) >= 3


@pytest.mark.parametrize("contacts", [2, 8])
def test_the_two_qp_solvers_agree(contacts: int) -> None:
    problem = soft_body(1, contacts=contacts, controls=16)
    fast, slow = (ScaledContactQPCC(problem, b) for b in (DAQPSolver(), PIQPSolver()))
    rng = np.random.default_rng(0)
    for _ in range(30):
        modes = tuple(int(mode) for mode in rng.integers(0, 18, size=contacts))
        here, there = fast.solve(modes), slow.solve(modes)
        assert (here is None) == (there is None)
        if here is not None and there is not None:
            # Both accept scaled residuals and gaps of 1e-6 at most.
            np.testing.assert_allclose(here.value, there.value, rtol=1e-6, atol=1e-6)


def test_unknown_settings_of_daqp_are_refused() -> None:
    with pytest.raises(InputError, match="no setting"):
        DAQPSolver(settings={"max_itre": 3})
    with pytest.raises(InputError, match="cannot be"):
        DAQPSolver(settings={"iter_limit": "many"})
