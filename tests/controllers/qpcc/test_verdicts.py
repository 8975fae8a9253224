"""Verdicts of the general form are true: in any units, and against problems of known answers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.qpcc.random_problems import KINDS, SCALINGS, ScaledCase, cases
from warp_softbody.controllers.qp.certificates import proves_infeasible, proves_unbounded
from warp_softbody.controllers.qp.certified import CertifiedSolver
from warp_softbody.controllers.qp.problem import QPProblem, QPStatus
from warp_softbody.controllers.qpcc import QPCC, QPCCStatus, enumerate_qpcc, solve_qpcc

CASES = cases(len(KINDS) * len(SCALINGS))
PAIR: dict[str, Any] = {"L": [[1.0, 0.0]], "R": [[0.0, 1.0]]}


def qpcc(**values: Any) -> QPCC:
    """A problem of plain lists."""
    return QPCC(**values)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_verdict_is_that_of_any_other_units(case: ScaledCase) -> None:
    plain, scaled = solve_qpcc(case.plain), solve_qpcc(case.scaled)
    kind = case.name.split()[0]
    expected = {"infeasible": QPCCStatus.INFEASIBLE, "unbounded": QPCCStatus.UNBOUNDED}
    assert plain.status is scaled.status is expected.get(kind, QPCCStatus.GLOBAL)
    if scaled.status is QPCCStatus.UNBOUNDED:
        assert scaled.ray is not None and scaled.lower_bound == -np.inf
        farther = scaled.x + 1e3 * scaled.ray / np.abs(scaled.ray / scaled.ray.max()).max()
        assert case.scaled.objective(farther) < scaled.objective
    if scaled.status is QPCCStatus.GLOBAL:
        # nodes are left within 1e-8 of the terms of the objective
        size = 1.0 + abs(plain.objective)
        assert abs(scaled.objective / case.factor - plain.objective) < 3e-6 * size
        assert plain.lower_bound <= plain.objective and plain.gap == 0.0


def test_a_steep_objective_and_rows_of_zeros_have_their_point() -> None:
    for slope, zeros in ((1e4, 4), (1e6, 0), (1e6, 3)):
        rows = np.r_[np.zeros(zeros), -1.0][:, None]
        found = solve_qpcc(qpcc(Q=[[1.0]], c=[-slope], G=rows, h=np.r_[np.ones(zeros), -1.0]))
        assert found.status is QPCCStatus.GLOBAL
        np.testing.assert_allclose(found.objective, -0.5 * slope**2, rtol=1e-6)


def test_little_curvature_is_bounded_and_little_slope_is_not() -> None:
    falling = solve_qpcc(qpcc(Q=np.zeros((2, 2)), c=[-1e-9, 1.0], **PAIR))
    assert falling.status is QPCCStatus.UNBOUNDED
    held = solve_qpcc(qpcc(Q=np.diag([1e-12, 1.0]), c=[-1.0, 0.0], **PAIR))
    assert held.status is QPCCStatus.GLOBAL
    np.testing.assert_allclose(held.x, [1e12, 0.0], rtol=1e-6, atol=1e-6)


def test_a_saddle_is_left_for_a_minimum_or_a_ray() -> None:
    hessian = np.diag([1.0, -1.0])
    for pairs in ({}, PAIR):
        falling = solve_qpcc(qpcc(Q=hessian, c=np.zeros(2), **pairs), budget=200)
        assert falling.status is QPCCStatus.UNBOUNDED and falling.ray is not None
    boxed = qpcc(Q=hessian, c=np.zeros(2), lb=[-1.0, -2.0], ub=[1.0, 3.0])
    np.testing.assert_allclose(solve_qpcc(boxed).objective, -4.5, rtol=1e-8)


@pytest.mark.parametrize("angle", [1e-4, 1e-6, 1e-8])
def test_rows_that_meet_far_away_prove_nothing(angle: float) -> None:
    """Rows x + y >= 1 and x + (1 + angle) y <= 0 meet at y = -1 / angle and beyond."""
    rows = [[1.0, 1.0], [1.0, 1.0 + angle]]
    ends = {"G": rows, "h": [np.inf, 0.0], "h_lower": [1.0, -np.inf]}
    found = solve_qpcc(qpcc(Q=np.eye(2), c=np.zeros(2), L=[[1.0, 0.0]], R=[[0.0, 0.0]], **ends))
    assert found.status is not QPCCStatus.INFEASIBLE
    parallel = {**ends, "G": [rows[0], rows[0]]}
    assert solve_qpcc(qpcc(Q=np.eye(2), c=np.zeros(2), **parallel)).status is QPCCStatus.INFEASIBLE


def test_a_point_between_nearly_parallel_rows_stays_where_its_qp_put_it() -> None:
    """Two rows apart by 1e-6: projected on both, the point went a third of its size away."""
    row = np.array([0.746, 0.17, -1.464, -0.374])
    problem = qpcc(
        Q=0.01 * np.eye(4)
        + [
            [0.318, 0.259, 0.175, -0.026],
            [0.259, 0.309, -0.119, -0.006],
            [0.175, -0.119, 0.941, 0.081],
            [-0.026, -0.006, 0.081, 0.129],
        ],
        c=[1.215, -0.151, 0.353, -0.554],
        G=[row, row + 1e-6 * np.array([-1.577, -0.874, -0.691, -2.142])],
        h=[-0.972, np.inf],
        h_lower=[-np.inf, -0.972],
        lb=[-2.0, -2.0, -10.0, -10.0],
        ub=[2.0, 2.0, 10.0, 10.0],
        L=[[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
        R=[[1.742, -0.444, 0.078, 0.163], [-0.891, -1.242, 0.163, 1.156]],
        r0=[1.27, 0.299],
    )
    # least of the four pieces by Clarabel
    for found in (solve_qpcc(problem), enumerate_qpcc(problem)):
        np.testing.assert_allclose(found.objective, -0.7084883481, rtol=1e-6)


def test_an_indefinite_problem_has_its_ray_or_its_point() -> None:
    """Saddles with a slope of their own, whose first linearisation has no minimum."""
    for seed in range(8):
        rng = np.random.default_rng([20, seed])
        turn, _ = np.linalg.qr(rng.normal(size=(4, 4)))
        hessian = turn @ np.diag([1.0, 0.5, -0.2, -1.0]) @ turn.T
        pairs = {"L": np.eye(2, 4), "R": rng.normal(size=(2, 4)), "r0": rng.normal(size=2)}
        free = solve_qpcc(qpcc(Q=hessian, c=rng.normal(size=4), **pairs))
        assert free.status is not QPCCStatus.NO_POINT
        if free.status is QPCCStatus.UNBOUNDED:
            ray = free.ray
            assert ray is not None and ray @ hessian @ ray < 0.0
            farther = free.x + 1e3 * ray / np.abs(ray).max()
            problem = qpcc(Q=hessian, c=np.zeros(4), **pairs)
            assert problem.complementarity(farther) < 1e-8
    apart = {"G": [[1.0, 0.0], [-1.0, 0.0]], "h": [-1.0, -1.0]}
    empty = solve_qpcc(qpcc(Q=np.diag([1.0, -1.0]), c=[0.0, 1.0], **apart, **PAIR))
    assert empty.status is QPCCStatus.INFEASIBLE


def test_a_bound_comes_with_every_answer_and_holds() -> None:
    problem = CASES[0].plain
    best = enumerate_qpcc(problem).objective
    for budget in (2, 4, 8, 50):
        found = solve_qpcc(problem, budget=budget)
        assert found.qp_count <= budget
        assert found.lower_bound <= best + 1e-6 * (1.0 + abs(best))
        assert not found.status.usable or found.gap >= 0.0


def test_enumeration_keeps_to_its_limit() -> None:
    found = enumerate_qpcc(CASES[0].plain, time_limit=1e-9)
    assert found.status is QPCCStatus.NO_POINT and found.gap == np.inf


def _two_rows(height: float) -> QPProblem:
    """X >= height and -x >= 0."""
    return QPProblem(
        P=np.eye(1),
        c=np.zeros(1),
        A=np.zeros((0, 1)),
        b=np.zeros(0),
        G=np.array([[1.0], [-1.0]]),
        h=np.array([height, 0.0]),
        lower=np.full(1, -np.inf),
        upper=np.full(1, np.inf),
    )


def test_certificates_are_recomputed_from_the_rows() -> None:
    solver = CertifiedSolver()
    for height in (1e-6, 1.0, 1e6):
        problem = _two_rows(height)
        answer = solver.solve(problem)
        assert answer.status is QPStatus.INFEASIBLE
        assert not proves_infeasible(_two_rows(-height), answer.multipliers)
    assert solver.solve(_two_rows(0.0)).status is QPStatus.SOLVED
    tilted = replace(_two_rows(-1.0), P=np.zeros((1, 1)), c=np.array([1.0]), G=np.zeros((2, 1)))
    assert proves_unbounded(tilted, np.array([-1.0]))
    assert not proves_unbounded(tilted, np.array([1.0]))
    assert not proves_unbounded(replace(tilted, P=np.array([[1e-12]])), np.array([-1.0]))
