"""Contact problems where methods fail: redundant contacts, extreme friction, sizes, units."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from tests.controllers.test_qpcc_search import soft_body
from warp_softbody.controllers import (
    ContactQPCC,
    QPCCStatus,
    SolverOptions,
    enumerate_qpcc,
    solve_qpcc,
    to_general,
)
from warp_softbody.controllers.daqp_backend import DAQPBackend
from warp_softbody.controllers.piqp_backend import PIQPBackend
from warp_softbody.controllers.reduced import ReducedProblem
from warp_softbody.errors import InputError

SHORT = SolverOptions(max_qps=60, kicks=6)


def changed(problem: ContactQPCC, **changes: Any) -> ContactQPCC:
    values = {entry.name: getattr(problem, entry.name) for entry in fields(problem)}
    return ContactQPCC(**(values | changes))


def repeated(problem: ContactQPCC, contacts: list[int]) -> ContactQPCC:
    """The problem with contacts listed again, so that Wf has no full rank."""
    nu = problem.control_count
    rows = np.concatenate([3 * i + np.arange(3) for i in contacts])
    z = np.r_[np.arange(nu), nu + rows]
    return changed(
        problem,
        hessian=problem.hessian[np.ix_(z, z)],
        gradient=problem.gradient[z],
        velocity_offset=problem.velocity_offset[rows],
        velocity_from_controls=problem.velocity_from_controls[rows],
        velocity_from_forces=problem.velocity_from_forces[np.ix_(rows, rows)],
        friction=problem.friction[contacts],
    )


@pytest.mark.parametrize("seed", range(3))
def test_redundant_contacts_give_consistent_points(seed: int) -> None:
    single = soft_body(seed, contacts=2, controls=8, directions=4)
    best = enumerate_qpcc(single).objective
    result = solve_qpcc(repeated(single, [0, 0, 1, 1, 1]), options=SHORT)
    assert result.status is not QPCCStatus.INACCURATE
    assert result.complementarity < 1e-8 and result.qp_count <= 60
    # The copies may share a load but gain nothing by it.
    assert result.objective >= best - 1e-6 * (1.0 + abs(best))


@pytest.mark.parametrize("friction", [0.0, 1e-12, 10.0])
def test_extreme_friction_against_enumeration(friction: float) -> None:
    for seed in range(4):
        problem = changed(
            soft_body(seed, contacts=2, controls=6, directions=4), friction=np.full(2, friction)
        )
        result, reference = solve_qpcc(problem, budget=200), enumerate_qpcc(problem)
        assert result.complementarity < 1e-8
        np.testing.assert_allclose(result.objective, reference.objective, rtol=1e-5, atol=1e-7)


def test_a_singular_objective_gives_consistent_points() -> None:
    for seed in range(4):
        problem = soft_body(seed, contacts=2, controls=30, directions=4)
        slopes = problem.hessian - np.diag(np.r_[np.full(30, 1e-2), np.zeros(6)])
        singular = changed(problem, hessian=0.5 * (slopes + slopes.T))
        result = solve_qpcc(singular, options=SHORT)
        assert result.complementarity < 1e-8
        assert result.objective >= enumerate_qpcc(singular).objective - 1e-6


def test_without_any_objective_a_consistent_point_comes_back() -> None:
    plain = soft_body(0, contacts=3, controls=6)
    nothing = changed(plain, hessian=np.zeros((15, 15)), gradient=np.zeros(15), constant=0.0)
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
    scaled = changed(
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
def test_the_two_backends_agree(contacts: int) -> None:
    problem = soft_body(1, contacts=contacts, controls=16)
    fast, slow = (ReducedProblem(problem, b) for b in (DAQPBackend(), PIQPBackend()))
    rng = np.random.default_rng(0)
    for _ in range(30):
        modes = tuple(int(mode) for mode in rng.integers(0, 18, size=contacts))
        here, there = fast.solve(modes), slow.solve(modes)
        assert (here is None) == (there is None)
        if here is not None and there is not None:
            # Both accept scaled residuals and gaps of 1e-6 at most.
            np.testing.assert_allclose(here.value, there.value, rtol=1e-6, atol=1e-6)


def test_unknown_settings_of_the_second_backend_are_refused() -> None:
    with pytest.raises(InputError, match="no setting"):
        DAQPBackend(settings={"max_itre": 3})
    with pytest.raises(InputError, match="cannot be"):
        DAQPBackend(settings={"iter_limit": "many"})
