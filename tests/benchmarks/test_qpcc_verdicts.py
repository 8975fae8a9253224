"""The judge of verdicts finds false ones, and lets true ones pass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.qpcc.peers.answer import PeerAnswer
from benchmarks.qpcc.random_problems import ScaledCase
from benchmarks.qpcc.verdicts import falls, fault, print_verdicts, violation
from warp_softbody.controllers.qpcc import QPCC, GeneralResult, QPCCStatus, solve_qpcc

# (x - 1)^2 + (y - 2)^2 on 0 <= x _|_ y >= 0: the minima are (0, 2) and, worse, (1, 0)
CORNER = QPCC(
    Q=2.0 * np.eye(2),
    c=np.array([-2.0, -4.0]),
    c0=5.0,
    L=np.eye(2)[:1],
    l0=np.zeros(1),
    R=np.eye(2)[1:],
    r0=np.zeros(1),
)
# the same pair, falling along y with a slope of 1e-6
FALLING = QPCC(
    Q=np.diag([2.0, 0.0]),
    c=np.array([-2.0, -1e-6]),
    L=np.eye(2)[:1],
    l0=np.zeros(1),
    R=np.eye(2)[1:],
    r0=np.zeros(1),
)


def said(problem: QPCC, result: GeneralResult, point: list[float] | None, verdict: str) -> str:
    x = None if point is None else np.array(point)
    answer = PeerAnswer(verdict=verdict, x=x, seconds=0.0)
    return fault(ScaledCase("case", problem, problem, 1.0), result, answer)


def test_a_worse_minimum_is_not_global() -> None:
    result = solve_qpcc(CORNER)
    assert result.status is QPCCStatus.GLOBAL and result.objective == pytest.approx(1.0)
    assert said(CORNER, result, [0.0, 2.0], "optimal") == ""
    assert "lower" in said(CORNER, replace(result, objective=4.0), [0.0, 2.0], "optimal")
    # a point of the judge that breaks the pair proves nothing
    assert said(CORNER, replace(result, objective=4.0), [1.0, 2.0], "optimal") == ""
    assert violation(CORNER, np.array([1.0, 2.0])) == pytest.approx(1.0)


def test_a_problem_with_a_point_is_not_infeasible() -> None:
    result = replace(solve_qpcc(CORNER), status=QPCCStatus.INFEASIBLE)
    assert said(CORNER, result, [1.0, 0.0], "optimal") == "there is a point"
    assert said(CORNER, result, None, "infeasible") == ""


def test_a_ray_is_tested_by_itself() -> None:
    result = solve_qpcc(FALLING)
    assert result.status is QPCCStatus.UNBOUNDED and falls(FALLING, result)
    assert said(FALLING, result, [1.0, 0.0], "optimal") == ""
    for ray in ([0.0, -1.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]):
        wrong = replace(result, ray=np.array(ray))
        assert not falls(FALLING, wrong)
        assert said(FALLING, wrong, None, "none") == "the ray is none"


def test_without_the_judge_a_sentence_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    print_verdicts(2)
    assert "pip install pyscipopt" in capsys.readouterr().out
