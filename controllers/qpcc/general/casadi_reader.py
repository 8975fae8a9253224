"""A QPCC from expressions of CasADi, which is not needed otherwise.

Objective and constraints are those of ``casadi.qpsol``: a dictionary with ``x``, ``f`` and ``g``.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc.general.problem import QPCC
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks


def from_casadi(
    qp: Mapping[str, Any],
    *,
    left: Any = None,
    right: Any = None,
    lbx: FloatArray | float = -np.inf,
    ubx: FloatArray | float = np.inf,
    lbg: FloatArray | float = -np.inf,
    ubg: FloatArray | float = np.inf,
) -> QPCC:
    """The problem of a CasADi QP whose expressions ``left`` and ``right`` are the sides of pairs.

    Args:
        qp: ``{"x": variables, "f": quadratic objective, "g": linear constraints}``, the last left
            out where there are none.
        left: expressions, linear in x, one a pair; default no pairs.
        right: as many.
        lbx: bounds of x, (n,) or one for all.
        ubx: likewise.
        lbg: bounds of g; equal ones make an equation.
        ubg: likewise.

    Raises:
        InputError: CasADi is not installed, or an expression is not linear or quadratic in x.
    """
    try:
        casadi = import_module("casadi")
    except ImportError as error:
        raise InputError("from_casadi needs CasADi: pip install casadi") from error
    if not isinstance(qp, Mapping) or not {"x", "f"} <= set(qp):
        raise InputError('qp of from_casadi must be a dictionary with "x" and "f"')
    x = qp["x"]
    try:
        count = int(x.numel())
        if not casadi.is_quadratic(qp["f"], x):
            raise InputError("f of from_casadi must be quadratic in x")
        hessian, gradient, constant = casadi.quadratic_coeff(qp["f"], x)
        parts = {"Q": _matrix(casadi, hessian), "c": _matrix(casadi, gradient).reshape(-1)}
        rows, sides = _linear(casadi, "g", qp.get("g"), x)
        pairs = {}
        for name, offset, given in (("L", "l0", left), ("R", "r0", right)):
            label = "left" if name == "L" else "right"
            pairs[name], pairs[offset] = _linear(casadi, label, given, x)
        c0 = float(_matrix(casadi, constant).reshape(-1)[0])
    except InputError:
        raise
    except Exception as error:
        # CasADi raises errors of many kinds for what is no expression of x
        raise InputError(f"CasADi cannot read the problem: {error}") from error
    low = _spread("lbg", lbg, len(sides)) - sides
    high = _spread("ubg", ubg, len(sides)) - sides
    fixed = low == high
    return QPCC(
        **parts,
        c0=c0,
        A=rows[fixed],
        b=high[fixed],
        G=rows[~fixed],
        h=high[~fixed],
        h_lower=low[~fixed],
        lb=_spread("lbx", lbx, count),
        ub=_spread("ubx", ubx, count),
        **pairs,
    )


def _matrix(casadi: Any, expression: Any) -> FloatArray:
    """The numbers of an expression without variables."""
    return np.array(casadi.evalf(expression).full(), np.float64)


def _linear(casadi: Any, label: str, expression: Any, x: Any) -> tuple[FloatArray, FloatArray]:
    """Matrix and constants of expressions that are linear in x."""
    if expression is None:
        return np.zeros((0, int(x.numel()))), np.zeros(0)
    column = casadi.vec(expression)
    if not casadi.is_linear(column, x):
        raise InputError(f"{label} of from_casadi must be linear in x")
    matrix, constants = casadi.linear_coeff(column, x)
    return _matrix(casadi, matrix), _matrix(casadi, constants).reshape(-1)


def _spread(label: str, value: FloatArray | float, count: int) -> FloatArray:
    """Bounds as (count,), a single one repeated."""
    given = array_checks.array(f"{label} of from_casadi", value, None, finite=False)
    if given.size == 1:
        return np.full(count, float(given.reshape(-1)[0]))
    if given.size != count:
        raise InputError(f"{label} of from_casadi must hold {count} numbers, not {given.size}")
    flat: FloatArray = given.reshape(-1)
    return flat
