"""Bounds of nodes by convex reformulation: products of the pairs join the objective.

At every consistent point ``left_i(x) right_i(x) = 0``, and where a pair is relaxed the product is
not negative. With weights w >= 0 the objective ``f + sum_i w_i left_i right_i`` has therefore the
same minimum, and its relaxations have higher bounds, as long as it stays convex (quadratic convex
reformulation; Billionnet, Elloumi and Plateau 2009 for binary programs).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack, solve_triangular

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.sparse_or_dense import is_sparse, to_dense
from warp_softbody.controllers.qpcc.general.piece_qp import Relaxation, ScaledQPCC
from warp_softbody.controllers.qpcc.general.piece_solution import PieceSolution

ROUNDS = 8
"""Most changes of the weights."""

KEPT = 0.98
"""Share of the weights at which the objective would stop to be convex."""

SHIFT = 1e-9
"""What makes a semidefinite matrix definite; problems come scaled."""

EQUATIONS = 10.0
"""Weight of the squares of the equations, which change nothing where these hold."""

LARGEST_WEIGHT = 1e3
"""Weights beyond this would drown the objective."""

GAIN = 1e-3
"""Least rise of the bound, relative to the first one, for which another round is worth it."""

LARGEST = 400
"""Variables above which it is not tried: a round takes their number cubed."""


@dataclass(frozen=True)
class _Parts:
    """The objective with the squares of the equations, and the inverse of its Cholesky factor."""

    hessian: FloatArray
    gradient: FloatArray
    constant: float
    inverse: FloatArray


def reformulate(
    general: ScaledQPCC, root: PieceSolution, solve: Callable[[Relaxation], PieceSolution | None]
) -> tuple[Relaxation, PieceSolution] | None:
    """The weights that raise the bound of the relaxation most, of a few that are tried.

    ``solve`` minimises on the relaxation of all pairs, or says None where the budget is used up.
    None comes back where nothing raises the bound.
    """
    if not len(general.l0) or is_sparse(general.convex_part) or len(general.c) > LARGEST:
        return None
    parts = _parts(general)
    if parts is None:
        return None
    weights = np.ones(len(general.l0))
    best, highest = None, root.bound
    for _ in range(ROUNDS):
        weights = _scaled_to_convexity(general, parts, weights)
        relaxation = _relaxation(general, parts, weights)
        found = solve(relaxation)
        if found is None or not found.bound > highest:
            break
        little = found.bound - highest < GAIN * abs(found.bound - root.bound)
        best, highest = (relaxation, found), found.bound
        product = np.maximum(found.left, 0.0) * np.maximum(found.right, 0.0)
        if little or not product.any():
            break
        weights = weights * (1.0 + 2.0 * product / product.max())
    return best


def _parts(general: ScaledQPCC) -> _Parts | None:
    equations = to_dense(general.equations)
    hessian = general.Q + EQUATIONS * equations.T @ equations
    size = len(hessian)
    shifted = hessian.copy()
    shifted.reshape(-1)[:: size + 1] += SHIFT
    factor, failed = lapack.dpotrf(shifted, lower=1)
    if failed:
        return None
    return _Parts(
        hessian=shifted,
        gradient=general.c - EQUATIONS * (general.sides_of_equations @ equations),
        constant=0.5 * EQUATIONS * float(general.sides_of_equations @ general.sides_of_equations),
        inverse=solve_triangular(np.tril(factor), np.eye(size), lower=True),
    )


def _products(general: ScaledQPCC, weights: FloatArray) -> FloatArray:
    """The second derivative of the weighted products."""
    half = general.L.T @ (weights[:, None] * general.R)
    both: FloatArray = half + half.T
    return both


def _scaled_to_convexity(general: ScaledQPCC, parts: _Parts, weights: FloatArray) -> FloatArray:
    """The largest multiple of some weights that leaves the objective convex."""
    products = parts.inverse @ _products(general, weights) @ parts.inverse.T
    least = float(np.linalg.eigvalsh(products)[0])
    most = LARGEST_WEIGHT / float(weights.max())
    scaled: FloatArray = weights * min(most, KEPT / -least if least < 0.0 else np.inf)
    return scaled


def _relaxation(general: ScaledQPCC, parts: _Parts, weights: FloatArray) -> Relaxation:
    hessian = parts.hessian + _products(general, weights)
    linear = (weights * general.l0) @ general.R + (weights * general.r0) @ general.L
    # the shift that made the matrix definite raises the objective by less than this
    return Relaxation(
        hessian=0.5 * (hessian + hessian.T),
        gradient=parts.gradient + linear,
        constant=parts.constant + float(weights @ (general.l0 * general.r0)),
        shift=SHIFT,
    )
