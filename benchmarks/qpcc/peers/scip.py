"""SCIP (``pip install pyscipopt``): branch and bound on special ordered sets of the pairs."""

from __future__ import annotations

import time

import numpy as np

from benchmarks.qpcc.peers.answer import PeerAnswer
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc import QPCC

VERDICTS = {"optimal": "optimal", "infeasible": "infeasible", "unbounded": "unbounded"}


def solve(problem: QPCC, time_limit: float = 60.0, *, feasibility: float = 1e-7) -> PeerAnswer:
    """Minimise; the objective is bounded by a variable of its own, as SCIP wants it linear."""
    from pyscipopt import Model, quicksum

    began = time.process_time()
    model = Model()
    model.hideOutput()
    model.setParam("limits/time", time_limit)
    model.setParam("numerics/feastol", feasibility)
    model.setParam("limits/gap", 1e-9)

    def bound(value: float) -> float | None:
        return float(value) if np.isfinite(value) else None

    x = [
        model.addVar(lb=bound(low), ub=bound(high))
        for low, high in zip(problem.lb, problem.ub, strict=True)
    ]

    def affine(row: FloatArray, constant: float = 0.0) -> object:
        return quicksum(float(row[j]) * x[j] for j in np.flatnonzero(row)) + float(constant)

    for row, side in zip(problem.A, problem.b, strict=True):
        _add(model, row, affine(row), "==", side)
    for row, low, high in zip(problem.G, problem.h_lower, problem.h, strict=True):
        if np.isfinite(high):
            _add(model, row, affine(row), "<=", high)
        if np.isfinite(low):
            _add(model, row, affine(row), ">=", low)
    for left, l0, right, r0 in zip(problem.L, problem.l0, problem.R, problem.r0, strict=True):
        pair = [model.addVar(lb=0.0), model.addVar(lb=0.0)]
        model.addCons(pair[0] == affine(left, l0))
        model.addCons(pair[1] == affine(right, r0))
        model.addConsSOS1(pair)
    objective = affine(problem.c)
    if np.any(problem.Q):
        size = float(np.abs(problem.Q).max())
        values, vectors = np.linalg.eigh(0.5 * (problem.Q + problem.Q.T))
        square = model.addVar(lb=0.0)
        used = values > 1e-13 * size
        roots = vectors[:, used] * np.sqrt(values[used])
        along = []
        for k in range(roots.shape[1]):
            y = model.addVar(lb=None)
            model.addCons(y == affine(roots[:, k]))
            along.append(y)
        model.addCons(quicksum(0.5 * y * y for y in along) <= square)
        objective = objective + square
    model.setObjective(objective, "minimize")
    try:
        model.optimize()
    except Exception:
        # its LP solver gives up on some problems
        return PeerAnswer(verdict="none", x=None, seconds=time.process_time() - began)
    verdict = VERDICTS.get(model.getStatus(), "none")
    point = None
    if verdict not in ("infeasible", "unbounded") and model.getNSols():
        best = model.getBestSol()
        point = np.array([model.getSolVal(best, variable) for variable in x])
        verdict = "optimal" if verdict == "optimal" else "point"
    return PeerAnswer(
        verdict=verdict,
        x=point,
        seconds=time.process_time() - began,
        bound=float(model.getDualbound()) + problem.c0,
    )


def _add(model: object, row: FloatArray, expression: object, sense: str, side: float) -> None:
    """Add a row; one without coefficients holds or not by its constant."""
    if not np.any(row):
        holds = {"==": side == 0.0, "<=": side >= 0.0, ">=": side <= 0.0}[sense]
        if not holds:
            nothing = model.addVar(lb=0.0, ub=0.0)  # type: ignore[attr-defined]
            model.addCons(nothing == 1.0)  # type: ignore[attr-defined]
        return
    side = float(side)
    if sense == "==":
        model.addCons(expression == side)  # type: ignore[attr-defined]
    elif sense == "<=":
        model.addCons(expression <= side)  # type: ignore[attr-defined,operator]
    else:
        model.addCons(expression >= side)  # type: ignore[attr-defined,operator]
