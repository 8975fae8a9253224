"""B-stationarity: no consistent direction from a point lowers the objective at first order.

The directions solve a linear program with complementarity constraints of its own, in which only the
biactive pairs still have a choice. That program is solved by branch and bound, so that the answer
is one also where multipliers are not unique.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc.general.problem import QPCC
from warp_softbody.controllers.qpcc.general.solve import enumerate_general
from warp_softbody.controllers.qpcc.result import QPCCStatus
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import Value

STEEP = 1e-6
"""Slope, relative to the gradient's largest scaled entry, below which there is no descent."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class BStationarity(Value):
    """What is known of the directions at a point.

    Attributes:
        stationary: no consistent direction is one of descent; False where one is, or where the
            limit of time ended the search for one.
        slope: least derivative of the objective along a consistent direction whose scaled entries
            are at most one; 0 at a B-stationary point.
        direction: (n,), of that slope.
        biactive: numbers of the pairs with both sides zero.
    """

    stationary: bool
    slope: float
    direction: FloatArray
    biactive: tuple[int, ...]


def b_stationarity(
    problem: QPCC, x: FloatArray, *, tolerance: float = 1e-6, time_limit: float | None = None
) -> BStationarity:
    """Whether a consistent point is B-stationary, which every local minimum is.

    Args:
        problem: in general form.
        x: (n,), a consistent point.
        tolerance: scaled size of a side, slack or distance from a bound that counts as zero.
        time_limit: s; default none.

    Raises:
        InputError: the point misses the tolerance.
    """
    checks.instance("problem of b_stationarity", problem, QPCC)
    x = array_checks.array("x of b_stationarity", x, (problem.variable_count,))
    tolerance = checks.number("tolerance of b_stationarity", tolerance, above=0.0)
    limit = np.inf
    if time_limit is not None:
        limit = checks.number("time_limit of b_stationarity", time_limit, above=0.0, infinite=True)
    miss = max(problem.complementarity(x), problem.feasibility(x))
    if miss > tolerance:
        raise InputError(
            f"x of b_stationarity must be a consistent point, but it misses {miss:.1e}"
        )
    directions, biactive, unit = _directions(problem, x, tolerance)
    steepest = enumerate_general(directions, limit)
    size = float(np.abs(directions.c).max()) or 1.0
    slope = min(steepest.objective, 0.0)
    known = steepest.status is QPCCStatus.GLOBAL
    return BStationarity(
        stationary=known and slope >= -STEEP * size,
        slope=slope,
        direction=steepest.x * unit,
        biactive=tuple(int(pair) for pair in biactive),
    )


def _directions(
    problem: QPCC, x: FloatArray, tolerance: float
) -> tuple[QPCC, np.ndarray[tuple[int], np.dtype[np.intp]], FloatArray]:
    """The program of the directions in scaled units, its biactive pairs, and the units."""
    scales = problem.equilibration
    _, over_row, over_left, over_right = scales.blocks
    unit = scales.variables
    left, right = problem.sides(x)
    left_zero, right_zero = left / over_left <= tolerance, right / over_right <= tolerance
    both = left_zero & right_zero
    values = problem.G @ x
    top = (problem.h - values) / over_row <= tolerance
    bottom = (values - problem.h_lower) / over_row <= tolerance
    on_low, on_high = (x - problem.lb) / unit <= tolerance, (problem.ub - x) / unit <= tolerance
    equations = np.concatenate(
        [problem.A, problem.L[left_zero & ~both], problem.R[right_zero & ~both]]
    )
    rows = np.concatenate([problem.G[top], -problem.G[bottom]])
    count = len(x)
    return (
        QPCC(
            Q=np.zeros((count, count)),
            c=(problem.Q @ x + problem.c) * unit,
            A=equations * unit,
            b=np.zeros(len(equations)),
            G=rows * unit,
            h=np.zeros(len(rows)),
            lb=np.where(on_low, 0.0, -1.0),
            ub=np.where(on_high, 0.0, 1.0),
            L=problem.L[both] * unit,
            R=problem.R[both] * unit,
        ),
        np.flatnonzero(both),
        unit,
    )
