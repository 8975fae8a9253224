"""An indefinite quadratic form as the difference of two convex ones."""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack

from warp_softbody.arrays import FloatArray

ROUNDING = 1e-12
"""Relative size of a negative eigenvalue that passes for rounding of a semidefinite matrix."""


def convex_concave_split(hessian: FloatArray) -> tuple[FloatArray, FloatArray | None]:
    """P and N, both positive semidefinite, with ``Q = P - N``; N is None where Q is semidefinite.

    The split is that of the eigenvalues by their signs.
    """
    shifted = hessian.copy()
    shifted.reshape(-1)[:: len(hessian) + 1] += ROUNDING * len(hessian)
    if not np.any(hessian) or not lapack.dpotrf(shifted)[1]:
        return hessian, None
    values, vectors = np.linalg.eigh(hessian)
    if values[0] >= -ROUNDING * max(1.0, abs(values[-1])) * len(values):
        return hessian, None
    concave = (vectors * np.maximum(-values, 0.0)) @ vectors.T
    convex = hessian + concave
    return 0.5 * (convex + convex.T), 0.5 * (concave + concave.T)
