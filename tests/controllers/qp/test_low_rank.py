"""An objective given as a diagonal and few squares: the same problem, the same answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.contact_problems import soft_body
from warp_softbody.controllers import ContactQPCC, solve_qpcc
from warp_softbody.controllers.qp.daqp import DAQPSolver
from warp_softbody.controllers.qp.diagonal_plus_low_rank import (
    DiagonalPlusLowRank,
    unconstrained_minimum,
)
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qp.problem import QPProblem, QPStatus
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC
from warp_softbody.errors import InputError

EFFORT = 1e-2
"""Of ``soft_body``: what its Hessian has on the diagonal of the controls beyond eight squares."""


def with_squares(problem: ContactQPCC) -> ContactQPCC:
    """The same problem, with its eight squares read off the Hessian."""
    rest = problem.hessian.copy()
    controls = np.arange(problem.control_count)
    rest[controls, controls] -= EFFORT
    sizes, vectors = np.linalg.eigh(rest)
    return replace(problem, squares=(vectors[:, -8:] * np.sqrt(sizes[-8:])).T)


@pytest.mark.parametrize("contacts", [1, 4])
def test_every_choice_of_modes_has_the_same_minimum(contacts: int) -> None:
    plain = soft_body(3, contacts=contacts, controls=40)
    one, other = (ScaledContactQPCC(p, DAQPSolver()) for p in (plain, with_squares(plain)))
    rng = np.random.default_rng(0)
    for _ in range(30):
        modes = tuple(int(mode) for mode in rng.integers(0, 18, size=contacts))
        here, there = one.solve(modes), other.solve(modes)
        assert (here is None) == (there is None)
        if here is not None and there is not None:
            # Curvatures span a factor of 1e4, and rows are met to 1e-10.
            np.testing.assert_allclose(here.controls, there.controls, atol=1e-6)
            np.testing.assert_allclose(here.multipliers, there.multipliers, atol=1e-6)
            np.testing.assert_allclose(here.value, there.value, rtol=1e-9, atol=1e-9)


def test_a_limit_ends_the_same_solves_early() -> None:
    plain = soft_body(5, contacts=4, controls=40)
    one, other = (ScaledContactQPCC(p, DAQPSolver()) for p in (plain, with_squares(plain)))
    rng = np.random.default_rng(0)
    refused = 0
    for _ in range(30):
        modes = tuple(int(mode) for mode in rng.integers(0, 18, size=4))
        known = one.solve(modes)
        if known is not None:
            limits = (known.value - 0.1 * abs(known.value), known.value + 0.1 * abs(known.value))
            assert [other.solve(modes, limit) is None for limit in limits] == [True, False]
            refused += 1
    assert refused > 3


def test_a_whole_solve_is_the_same() -> None:
    for seed in range(4):
        plain = soft_body(seed, contacts=4, controls=40)
        one, other = (solve_qpcc(p, start=(1,) * 4) for p in (plain, with_squares(plain)))
        assert one.modes == other.modes and one.status is other.status
        np.testing.assert_allclose(one.objective, other.objective, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(one.controls, other.controls, atol=1e-6)
        assert other.complementarity < 1e-9 and other.stationarity < 1e-9


def test_a_matrix_of_a_diagonal_and_low_rank_is_what_it_says() -> None:
    rng = np.random.default_rng(1)
    matrix = DiagonalPlusLowRank(rng.uniform(0.1, 2.0, 12), rng.normal(size=(3, 12)))
    c = rng.normal(size=12)
    whole = np.diag(matrix.diagonal) + matrix.factor.T @ matrix.factor
    np.testing.assert_allclose(matrix.toarray(), whole, atol=1e-14)
    np.testing.assert_allclose(matrix @ c, whole @ c, atol=1e-13)
    least = -0.5 * c @ np.linalg.solve(whole, c)
    for form in (matrix, whole):
        assert unconstrained_minimum(form, c) == pytest.approx(least, rel=1e-12)


def test_both_solvers_take_such_a_matrix() -> None:
    rng = np.random.default_rng(2)
    matrix = DiagonalPlusLowRank(rng.uniform(0.1, 2.0, 12), rng.normal(size=(3, 12)))
    promatrix = QPProblem(
        P=matrix,
        c=rng.normal(size=12),
        A=np.zeros((0, 12)),
        b=np.zeros(0),
        G=rng.normal(size=(4, 12)),
        h=np.full(4, 0.2),
        lower=np.full(12, -0.4),
        upper=np.full(12, 0.4),
    )
    fast = DAQPSolver().solve(promatrix)
    slow = PIQPSolver().solve(replace(promatrix, P=matrix.toarray()))
    assert fast.status is slow.status is QPStatus.SOLVED
    np.testing.assert_allclose(fast.x, slow.x, atol=1e-6)
    assert fast.dual_residual < 1e-10


def test_squares_that_are_not_the_hessian_are_refused() -> None:
    good = with_squares(soft_body(0, contacts=1, controls=40))
    for squares in (1.01 * good.squares, np.vstack([good.squares, np.eye(43)[:1]])):
        with pytest.raises(InputError, match="squares"):
            replace(good, squares=squares)
    with pytest.raises(InputError, match="squares must be"):
        replace(good, squares=good.squares[:, 1:])
