"""The general QPCC: known optima by enumeration, honest statuses, and what breaks solvers."""

from __future__ import annotations

import itertools
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.sparse import issparse

from warp_softbody.controllers import QPCC, QPCCStatus, enumerate_qpcc, solve_qpcc
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qp.problem import QPProblem, QPStatus
from warp_softbody.controllers.qpcc.general.piece_qp import ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import OPEN
from warp_softbody.controllers.qpcc.result import GeneralMultipliers, SolverOptions
from warp_softbody.errors import InputError

USABLE = {
    QPCCStatus.GLOBAL,
    QPCCStatus.STRONGLY_STATIONARY,
    QPCCStatus.NO_IMPROVING_FLIP,
    QPCCStatus.BUDGET,
}


def random_problem(seed: int, *, n: int = 6, p: int = 5, rank: int | None = None) -> QPCC:
    """Upper variables within bounds, and a monotone complementarity system for the lower ones.

    ``0 <= y _|_ M y + N x + q >= 0`` with M positive definite has one y for every x, so that a
    point always exists.
    """
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(rank if rank is not None else n + p, n + p))
    lower = rng.normal(size=(p, p))
    right = np.hstack([rng.normal(size=(p, n)), lower @ lower.T / p + 0.1 * np.eye(p)])
    return QPCC(
        Q=factor.T @ factor / len(factor),
        c=rng.normal(size=n + p),
        c0=1.5,
        lb=np.r_[np.full(n, -1.0), np.full(p, -np.inf)],
        ub=np.r_[np.full(n, 1.0), np.full(p, np.inf)],
        L=np.hstack([np.zeros((p, n)), np.eye(p)]),
        l0=np.zeros(p),
        R=right,
        r0=rng.normal(size=p),
    )


def brute_force(problem: QPCC) -> float:
    """Least objective over all 2^p choices of zero sides, one QP each."""
    best, qp_solver = np.inf, PIQPSolver()
    for choice in itertools.product((False, True), repeat=problem.pair_count):
        side = np.array(choice)
        zero = np.where(side[:, None], problem.R, problem.L)
        kept = np.where(side[:, None], problem.L, problem.R)
        solution = qp_solver.solve(
            QPProblem(
                P=problem.Q,
                c=problem.c,
                A=np.concatenate([problem.A, zero]),
                b=np.concatenate([problem.b, -np.where(side, problem.r0, problem.l0)]),
                G=np.concatenate([-problem.G, kept]),
                h=np.concatenate([-problem.h, -np.where(side, problem.l0, problem.r0)]),
                lower=problem.lb,
                upper=problem.ub,
            )
        )
        if solution.status is QPStatus.SOLVED:
            best = min(best, solution.value + problem.c0)
    return best


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("rank", [None, 3])
def test_small_problems_are_solved_globally(seed: int, rank: int | None) -> None:
    problem = random_problem(seed, rank=rank)
    result, best = solve_qpcc(problem), brute_force(problem)
    # The QPs' duality gap is asked to 1e-12 and accepted to 1e-6.
    np.testing.assert_allclose(result.objective, best, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(enumerate_qpcc(problem).objective, best, rtol=1e-6, atol=1e-6)
    assert result.status is QPCCStatus.GLOBAL
    assert result.complementarity < 1e-8 and result.feasibility < 1e-8
    assert result.stationarity < 1e-6
    assert problem.objective(result.x) == result.objective


def test_the_multipliers_balance_the_gradient() -> None:
    problem = replace(random_problem(3), G=np.ones((1, 11)), h=np.array([0.5]))
    result = solve_qpcc(problem)
    known = result.multipliers
    assert isinstance(known, GeneralMultipliers)
    balance = known.lower - known.upper - known.inequalities @ problem.G
    balance += known.left @ problem.L + known.right @ problem.R
    # Accepted QPs have scaled dual residuals below 1e-6.
    np.testing.assert_allclose(problem.Q @ result.x + problem.c, balance, atol=1e-5)
    assert min(known.lower.min(), known.upper.min(), known.inequalities.min()) >= 0.0


@pytest.mark.parametrize("seed", range(3))
def test_more_pairs_than_branch_and_bound_takes(seed: int) -> None:
    problem = random_problem(seed, n=8, p=45)
    result = solve_qpcc(problem, budget=120)
    assert result.status in USABLE - {QPCCStatus.GLOBAL}
    assert result.qp_count <= 120 and result.complementarity < 1e-8


@pytest.mark.parametrize("budget", [12, 40, 150, 2000])
def test_what_ends_below_its_budget_is_proved(budget: int) -> None:
    problem = random_problem(3, n=12, p=14)
    found = solve_qpcc(problem, budget=budget)
    assert found.status is QPCCStatus.GLOBAL or found.qp_count >= budget


def test_starts_seeds_and_budgets() -> None:
    problem = random_problem(1, n=8, p=45)
    first, second = (solve_qpcc(problem, budget=80, seed=5) for _ in range(2))
    np.testing.assert_array_equal(first.x, second.x)
    again = solve_qpcc(problem, start=first.modes, options=SolverOptions(kicks=0))
    assert again.objective <= first.objective + 1e-9 and again.qp_count <= 3
    point = solve_qpcc(problem, start=first.x, options=SolverOptions(kicks=0))
    np.testing.assert_allclose(point.objective, first.objective, rtol=1e-6)
    for limit in (1, 2, 5):
        limited = solve_qpcc(problem, budget=limit)
        assert limited.qp_count <= limit
        assert limited.complementarity < 1e-8 or limited.status is QPCCStatus.NO_POINT
    late = solve_qpcc(problem, time_limit=1e-9)
    assert late.status is QPCCStatus.NO_POINT
    soon = solve_qpcc(problem, time_limit=0.2)
    # One QP of this size and its bookkeeping may run over.
    assert soon.seconds < 1.0


def test_an_empty_feasible_set_is_called_infeasible() -> None:
    crossed = replace(
        random_problem(0), G=np.vstack([np.eye(11)[0], -np.eye(11)[0]]), h=np.array([-0.5, -0.5])
    )
    # Both sides at least one half: the relaxation has points, no combination of sides has.
    apart = QPCC(
        Q=np.eye(2),
        c=np.zeros(2),
        lb=np.full(2, 0.5),
        L=np.array([[1.0, 0.0]]),
        l0=np.zeros(1),
        R=np.array([[0.0, 1.0]]),
        r0=np.zeros(1),
    )
    for problem in (crossed, apart):
        for result in (solve_qpcc(problem), enumerate_qpcc(problem)):
            assert result.status is QPCCStatus.INFEASIBLE


def test_an_unbounded_objective_is_called_unbounded() -> None:
    # min -x on 0 <= x _|_ y >= 0: the piece y = 0 falls without end.
    pair: dict[str, Any] = {
        "L": np.array([[1.0, 0.0]]),
        "l0": np.zeros(1),
        "R": np.array([[0.0, 1.0]]),
        "r0": np.zeros(1),
    }
    falling = QPCC(Q=np.zeros((2, 2)), c=np.array([-1.0, 0.0]), **pair)
    assert solve_qpcc(falling).status is QPCCStatus.UNBOUNDED
    held = QPCC(Q=np.zeros((2, 2)), c=np.array([-1.0, 0.0]), ub=np.array([3.0, np.inf]), **pair)
    result = solve_qpcc(held)
    assert result.status is QPCCStatus.GLOBAL
    np.testing.assert_allclose(result.objective, -3.0, rtol=1e-8)


def test_a_bounded_problem_with_an_unbounded_relaxation() -> None:
    # min -x - y + 2 with x, y <= 1 only through the pair x _|_ y and x + y <= 1 on neither side
    problem = QPCC(
        Q=np.diag([0.0, 0.0, 1.0]),
        c=np.array([-1.0, -1.0, 0.0]),
        A=np.array([[1.0, -1.0, 0.0]]),
        b=np.zeros(1),
        L=np.array([[1.0, 0.0, 0.0]]),
        l0=np.zeros(1),
        R=np.array([[0.0, 1.0, 0.0]]),
        r0=np.zeros(1),
    )
    result = solve_qpcc(problem)
    assert result.status in USABLE
    np.testing.assert_allclose(result.x, 0.0, atol=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_badly_scaled_rows_change_nothing(seed: int) -> None:
    plain = random_problem(seed)
    rng = np.random.default_rng(seed)
    left, right = 10.0 ** rng.uniform(-8, 8, size=(2, 5))
    scaled = replace(
        plain,
        L=plain.L * left[:, None],
        l0=plain.l0 * left,
        R=plain.R * right[:, None],
        r0=plain.r0 * right,
        G=1e8 * np.ones((1, 11)),
        h=np.array([1e10]),
        A=np.zeros((1, 11)),
        b=np.zeros(1),
    )
    here, there = solve_qpcc(plain), solve_qpcc(scaled)
    assert there.status is QPCCStatus.GLOBAL and there.complementarity < 1e-8
    np.testing.assert_allclose(there.objective, here.objective, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_duplicate_pairs_and_rows_change_nothing(seed: int) -> None:
    plain = random_problem(seed)
    names = ("L", "l0", "R", "r0")
    twice: Any = {name: np.concatenate([getattr(plain, name)] * 2) for name in names}
    equations = np.tile(np.r_[1.0, -1.0, np.zeros(9)], (2, 1))
    double = replace(plain, A=equations, b=np.zeros(2), **twice)
    single = replace(plain, A=equations[:1], b=np.zeros(1))
    here, there = solve_qpcc(single), solve_qpcc(double)
    assert there.status in USABLE and there.complementarity < 1e-8
    np.testing.assert_allclose(there.objective, here.objective, rtol=1e-6, atol=1e-6)


def test_an_indefinite_objective_gives_a_point_and_claims_no_more() -> None:
    problem = replace(
        random_problem(0), Q=random_problem(0).Q - 2.0 * np.diag(np.r_[1, [0.0] * 10])
    )
    result = solve_qpcc(problem, budget=300)
    assert result.status in USABLE - {QPCCStatus.GLOBAL}
    assert result.complementarity < 1e-8
    with pytest.raises(InputError, match="semidefinite"):
        enumerate_qpcc(problem)


def test_sparse_matrices_give_what_dense_ones_do() -> None:
    """Thirty small problems side by side: 330 variables, few of whose entries are not zero."""
    parts = [random_problem(seed) for seed in range(30)]
    blocks = {
        name: block_diag(*(getattr(part, name) for part in parts)) for name in ("Q", "L", "R")
    }
    vectors: Any = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("c", "lb", "ub", "l0", "r0")
    }
    problem = QPCC(**(blocks | vectors))
    open_pairs = np.full(problem.pair_count, OPEN, np.int8)
    sparse = ScaledQPCC(problem, PIQPSolver())
    assert issparse(sparse.convex_part)
    dense = ScaledQPCC(problem, PIQPSolver(), sparse_above=1000)
    assert not issparse(dense.convex_part)
    known = np.concatenate([solve_qpcc(part).x for part in parts])
    closed = dense.nearest_sides(known / dense.variable_scale)
    for sides, proximal in itertools.product((open_pairs, closed), (0.0, 0.1)):
        center = np.ones(problem.variable_count)
        one = sparse.solve(sides, center=center, proximal=proximal)
        other = dense.solve(sides, center=center, proximal=proximal)
        assert one.status is other.status is QPStatus.SOLVED
        # Both accept scaled residuals and gaps of 1e-6 at most.
        np.testing.assert_allclose(one.value, other.value, rtol=2e-6, atol=2e-6)
    assert problem.feasibility(sparse.polish(sparse.solve(closed))) < 1e-8


def test_without_pairs_it_is_a_qp() -> None:
    result = solve_qpcc(QPCC(Q=np.eye(2), c=np.array([-2.0, 0.3]), ub=np.array([1.0, np.inf])))
    np.testing.assert_allclose(result.x, [1.0, -0.3], atol=1e-8)
    assert result.status is QPCCStatus.GLOBAL and result.modes == ()


ARRAYS = [entry.name for entry in fields(QPCC)]


@pytest.mark.parametrize("name", ARRAYS)
def test_nan_is_refused_with_the_name_of_the_field(name: str) -> None:
    problem = replace(random_problem(0), G=np.ones((1, 11)), h=np.ones(1))
    problem = replace(problem, A=np.ones((1, 11)), b=np.ones(1))
    value = np.array(getattr(problem, name), dtype=float)
    value.reshape(-1)[0] = np.nan
    wrong: dict[str, Any] = {name: value}
    with pytest.raises(InputError, match=name):
        replace(problem, **wrong)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"c": np.zeros(3)}, "must be"),
        ({"r0": np.zeros(2)}, "r0 must be"),
        ({"lb": np.full(11, 2.0)}, "leave no value"),
        ({"Q": np.triu(np.ones((11, 11)))}, "symmetric"),
    ],
)
def test_unusable_input_is_refused_with_a_sentence(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        replace(random_problem(0), **changes)


def test_unusable_calls_are_refused() -> None:
    problem = random_problem(0)
    for start in ((0, 0), (2, 0, 0, 0, 0), np.full(11, np.nan)):
        with pytest.raises(InputError, match="start"):
            solve_qpcc(problem, start=start)


def test_instances_are_read_by_name(tmp_path: Path) -> None:
    problem, path = random_problem(2), tmp_path / "one.npz"
    values = {name: getattr(problem, name) for name in ARRAYS}
    np.savez(path, names=np.array(["a"]), **values)
    loaded = QPCC.load(path)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(loaded, name), getattr(problem, name))
    path.write_bytes(b"no archive")
    with pytest.raises(InputError, match=r"one\.npz"):
        QPCC.load(path)
    with pytest.raises(InputError, match=r"none\.npz"):
        QPCC.load(tmp_path / "none.npz")
