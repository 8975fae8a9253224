"""DAQP and PIQP against a third solver, Clarabel by way of qpsolvers, on random convex QPs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_matrix

from warp_softbody.controllers.qp.daqp import DAQPSolver
from warp_softbody.controllers.qp.diagonal_plus_low_rank import DiagonalPlusLowRank
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qp.problem import QPProblem, QPSolver, QPStatus, polish
from warp_softbody.controllers.qp.sparse_or_dense import to_dense

qpsolvers = pytest.importorskip("qpsolvers")
pytest.importorskip("clarabel")

SOLVERS = pytest.mark.parametrize("solver", [DAQPSolver(), PIQPSolver()], ids=["daqp", "piqp"])
SEEDS = pytest.mark.parametrize("seed", range(25))

TOLERANCE = 1e-6
"""Of residuals and gaps that DAQPSolver and PIQPSolver accept."""

GAP = 1e-10
"""Residuals and duality gap that are asked of Clarabel."""

CURVATURE = 0.05
"""Least eigenvalue of the Hessian of strictly convex problems."""


def random_qp(seed: int, *, rank: int | None = None, equalities: int = 0) -> QPProblem:
    """A QP of 2 to 12 variables with a feasible point, half its variables bounded on both sides.

    A Hessian of less than full rank is given a point that all bounds surround.
    """
    rng = np.random.default_rng(seed)
    n, count = int(rng.integers(2, 13)), int(rng.integers(1, 21))
    factor = rng.normal(size=(n if rank is None else min(rank, n), n))
    point = rng.normal(size=n)
    rows, equations = rng.normal(size=(count, n)), rng.normal(size=(min(equalities, n - 1), n))
    bounded = rng.random(n) < (0.5 if rank is None else 1.0)
    return QPProblem(
        P=factor.T @ factor + (CURVATURE * np.eye(n) if rank is None else 0.0),
        c=3.0 * rng.normal(size=n),
        A=equations,
        b=equations @ point,
        G=rows,
        h=rows @ point - rng.random(count) * rng.integers(0, 2, size=count),
        lower=np.where(bounded, point - rng.random(n), -np.inf),
        upper=np.where(bounded, point + rng.random(n), np.inf),
    )


def oracle(problem: QPProblem) -> tuple[float, np.ndarray[tuple[int], np.dtype[np.float64]]] | None:
    """Least value and minimiser by Clarabel; None where it finds the problem infeasible."""
    equalities = problem.b.size > 0
    answer = qpsolvers.solve_problem(
        qpsolvers.Problem(
            P=csc_matrix(to_dense(problem.P)),
            q=problem.c,
            G=-csc_matrix(problem.G),
            h=-problem.h,
            A=csc_matrix(problem.A) if equalities else None,
            b=problem.b if equalities else None,
            lb=problem.lower,
            ub=problem.upper,
        ),
        solver="clarabel",
        tol_gap_abs=GAP,
        tol_gap_rel=GAP,
        tol_feas=GAP,
    )
    return (answer.obj, answer.x) if answer.found else None


def agree(solver: QPSolver, problem: QPProblem) -> None:
    known, solution = oracle(problem), solver.solve(problem)
    assert known is not None and solution.status is QPStatus.SOLVED
    np.testing.assert_allclose(solution.value, known[0], rtol=TOLERANCE, atol=TOLERANCE)
    assert max(solution.primal_residual, solution.dual_residual) <= TOLERANCE


@SOLVERS
@SEEDS
def test_strictly_convex_problems_have_the_same_minimiser(solver: QPSolver, seed: int) -> None:
    problem = random_qp(seed)
    agree(solver, problem)
    known = oracle(problem)
    assert known is not None
    polished = polish(problem, solver.solve(problem))
    # A gap g bounds the distance from the minimiser: g >= CURVATURE / 2 |x - x*|^2.
    distance = np.sqrt(2.0 * GAP * (1.0 + abs(known[0])) / CURVATURE)
    np.testing.assert_allclose(polished.x, known[1], atol=distance)


@SOLVERS
@SEEDS
def test_semidefinite_problems_have_the_same_value(solver: QPSolver, seed: int) -> None:
    agree(solver, random_qp(seed, rank=seed % 4))


@SOLVERS
@SEEDS
def test_equalities(solver: QPSolver, seed: int) -> None:
    agree(solver, random_qp(seed, equalities=1 + seed % 3))


@SOLVERS
@SEEDS
def test_degenerate_problems(solver: QPSolver, seed: int) -> None:
    """Every row twice, some variables fixed by their bounds, and a row that is zero."""
    plain = random_qp(seed)
    fixed = np.arange(len(plain.c)) % 3 == 0
    bounded = np.isfinite(plain.lower)
    middle = np.zeros(len(plain.c))
    middle[bounded] = 0.5 * (plain.lower[bounded] + plain.upper[bounded])
    rows = np.concatenate([plain.G, plain.G, 0.0 * plain.G[:1]])
    # The rows are moved so that the middle of the bounds, where all fixed variables are, is inside.
    inside = plain.G @ middle - np.abs(plain.h)
    agree(
        solver,
        replace(
            plain,
            G=rows,
            h=np.concatenate([inside, inside, np.zeros(1)]),
            lower=np.where(fixed, middle, plain.lower),
            upper=np.where(fixed, middle, plain.upper),
        ),
    )


@pytest.mark.filterwarnings("ignore:Clarabel.rs terminated with status PrimalInfeasible")
@SOLVERS
@SEEDS
def test_infeasible_problems_are_told(solver: QPSolver, seed: int) -> None:
    """Two rows that contradict each other by a tenth, or a row out of reach of the bounds."""
    plain = random_qp(seed)
    direction, size = plain.G[:1], float(plain.h[0])
    if seed % 2:
        rows = np.concatenate([plain.G, -direction])
        wrong = replace(plain, G=rows, h=np.append(plain.h, -size + 0.1))
    else:
        box = np.ones(len(plain.c))
        rows = np.append(plain.h[1:], np.abs(direction).sum() + 0.1)
        wrong = replace(plain, G=np.roll(plain.G, -1, axis=0), h=rows, lower=-box, upper=box)
    assert oracle(wrong) is None
    assert solver.solve(wrong).status is QPStatus.INFEASIBLE


@SEEDS
def test_a_hessian_of_a_diagonal_and_low_rank(seed: int) -> None:
    plain, rng = random_qp(seed), np.random.default_rng(seed)
    n = len(plain.c)
    hessian = DiagonalPlusLowRank(rng.uniform(0.1, 2.0, n), rng.normal(size=(1 + seed % 3, n)))
    agree(DAQPSolver(), replace(plain, P=hessian))


@SEEDS
def test_a_cutoff_below_the_minimum_ends_early_and_one_above_changes_nothing(seed: int) -> None:
    problem, solver = random_qp(seed), DAQPSolver()
    known = oracle(problem)
    assert known is not None
    above = known[0] + 0.5 * float(problem.c @ np.linalg.solve(problem.P, problem.c))
    whole = solver.solve(replace(problem, cutoff=1.01 * above + 1e-3))
    np.testing.assert_array_equal(whole.x, solver.solve(problem).x)
    if above > 1e-3:
        early = solver.solve(replace(problem, cutoff=0.9 * above))
        assert early.status is QPStatus.INFEASIBLE
