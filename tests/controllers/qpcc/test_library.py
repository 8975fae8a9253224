"""The general form as a library: what it reads, writes and logs, and the test of B-stationarity."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from warp_softbody.controllers.qpcc import QPCC, QPCCStatus, b_stationarity, from_casadi, solve_qpcc
from warp_softbody.errors import InputError

TARGET = np.array([0.8, 0.5])


def corner(**more: object) -> QPCC:
    """The point of y = max(0, 1 - x) nearest to the target."""
    values: dict[str, object] = {
        "Q": 2.0 * np.eye(2),
        "c": -2.0 * TARGET,
        "c0": float(TARGET @ TARGET),
        "L": np.array([[0.0, 1.0]]),
        "R": np.array([[1.0, 1.0]]),
        "r0": np.array([-1.0]),
    }
    return QPCC(**(values | more))  # type: ignore[arg-type]


def test_sparse_matrices_and_the_names_of_the_field() -> None:
    plain = corner()
    other = QPCC(
        P=sp.csr_matrix(plain.Q),  # type: ignore[arg-type]
        q=plain.c,
        c0=plain.c0,
        L=sp.csc_array(plain.L),  # type: ignore[arg-type]
        R=plain.R,
        r0=plain.r0,
    )
    assert other == plain
    with pytest.raises(InputError, match="not both"):
        QPCC(Q=plain.Q, P=plain.Q, c=plain.c)


def test_rows_have_two_sides() -> None:
    both = corner(G=np.array([[1.0, 0.0]]), h=np.array([0.7]), h_lower=np.array([0.66]))
    found = solve_qpcc(both)
    np.testing.assert_allclose(found.x, [0.66, 0.34], atol=1e-8)
    assert found.multipliers is not None
    # the lower side holds: d/dx of the squared distance along the piece x + y = 1
    np.testing.assert_allclose(found.multipliers.inequalities, [-0.04], atol=1e-6)  # type: ignore[union-attr]
    with pytest.raises(InputError, match="row 0"):
        corner(G=np.array([[1.0, 0.0]]), h=np.array([0.0]), h_lower=np.array([1.0]))


def test_saved_problems_are_read_again(tmp_path: Path) -> None:
    plain, path = corner(), tmp_path / "one.npz"
    plain.save(path)
    assert QPCC.load(path) == plain
    assert [entry.name for entry in tmp_path.iterdir()] == ["one.npz"]
    with pytest.raises(InputError, match="cannot write"):
        plain.save(tmp_path / "none" / "one.npz")
    np.savez(path, Q=np.ones((2, 3)), c=np.ones(2))
    with pytest.raises(InputError, match=r"one\.npz: QPCC\.Q"):
        QPCC.load(path)


@pytest.mark.parametrize("wrong", [np.eye(2) * 1j, [["a"]], [[1.0], [2.0, 3.0]]])
def test_matrices_that_are_none_are_refused(wrong: object) -> None:
    with pytest.raises(InputError, match=r"QPCC\.Q"):
        corner(Q=wrong)


def test_its_log_is_that_of_the_standard_library(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="warp_softbody.qpcc"):
        solve_qpcc(corner())
    assert "lower bound" in caplog.text


def test_b_stationarity_needs_no_multipliers() -> None:
    problem = corner()
    best = solve_qpcc(problem)
    assert best.status is QPCCStatus.GLOBAL
    here = b_stationarity(problem, best.x)
    assert here.stationary and here.biactive == ()
    # at the kink (1, 0) the way along x + y = 1 leads down
    kink = b_stationarity(problem, np.array([1.0, 0.0]))
    assert not kink.stationary and kink.biactive == (0,) and kink.slope < 0.0
    gradient = problem.Q @ np.array([1.0, 0.0]) + problem.c
    np.testing.assert_allclose(gradient @ kink.direction, kink.slope, rtol=1e-6)
    with pytest.raises(InputError, match="consistent"):
        b_stationarity(problem, np.zeros(2))


def test_a_casadi_problem_with_pairs() -> None:
    casadi = pytest.importorskip("casadi")
    x = casadi.SX.sym("x", 2)
    square = (x[0] - TARGET[0]) ** 2 + (x[1] - TARGET[1]) ** 2
    program = {"x": x, "f": square, "g": casadi.vertcat(x[0] - 5, x[0] - x[1])}
    sides = {"lbg": np.array([-np.inf, 0.5]), "ubg": np.array([0.0, 0.5])}
    read = from_casadi(program, left=x[1], right=x[0] + x[1] - 1, **sides)
    assert read.A.shape == (1, 2) and read.G.shape == (1, 2)
    np.testing.assert_allclose(solve_qpcc(read).x, [0.75, 0.25], atol=1e-8)
    with pytest.raises(InputError, match="linear"):
        from_casadi(program, left=x[1] ** 2, right=x[0])
    with pytest.raises(InputError, match="quadratic"):
        from_casadi({"x": x, "f": x[0] ** 4})


def test_casadi_problems_without_casadi_are_refused_with_a_sentence() -> None:
    with pytest.raises(InputError, match="from_casadi"):
        from_casadi({})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"c": [[0.0], [1.0]]}, r"QPCC\.c must be of shape \(n,\), not \(2, 1\)"),
        ({"A": [[1.0, 1.0]]}, r"QPCC\.b must be of shape \(1,\), not \(0,\)"),
        ({"lb": [np.nan, 0.0]}, r"QPCC\.lb must hold numbers, but it holds nan at \(0,\)"),
        ({"Q": [[1.0, 2.0], [0.0, 1.0]]}, r"symmetric, but it holds 2\.0 at \(0, 1\) and 0\.0"),
        ({"c": np.ma.array([0.0, 1.0], mask=[False, True])}, "masked"),
    ],
)
def test_the_sentence_names_the_array_at_fault(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        QPCC(**({"Q": np.eye(2), "c": np.zeros(2)} | changes))
