"""Matrices of a general QPCC, kept sparse where that pays: large problems with few entries.

``scipy.sparse`` is loaded by the first such problem, as most programs never meet one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from warp_softbody.arrays import FloatArray

Matrix: TypeAlias = Any
"""A float64 array, or a ``csr_array`` of such; both know ``@`` and boolean rows."""

SPARSE_SIZE = 150
"""Variables above which a problem with few entries is kept sparse."""

SPARSE_FILL = 0.1
"""Share of entries below which that is worth it."""

CONCAVE = 1e-12
"""Relative size of a negative eigenvalue of Q that passes for rounding."""


def held(*matrices: FloatArray) -> tuple[Matrix, ...]:
    """The matrices of one problem, all sparse or all as they are."""
    entries = sum(int(np.count_nonzero(matrix)) for matrix in matrices)
    small = matrices[0].shape[1] <= SPARSE_SIZE
    if small or entries >= SPARSE_FILL * sum(matrix.size for matrix in matrices):
        return matrices
    import scipy.sparse as sp

    return tuple(sp.csr_array(matrix) for matrix in matrices)


def is_sparse(matrix: Matrix) -> bool:
    """Whether a matrix is kept sparse."""
    return not isinstance(matrix, np.ndarray)


def stacked(parts: Sequence[Matrix]) -> Matrix:
    """Rows one below the other; sparse if the first ones are."""
    if not is_sparse(parts[0]):
        return np.concatenate(parts)
    import scipy.sparse as sp

    return sp.vstack(parts, format="csr")


def shifted(matrix: Matrix, amount: float) -> Matrix:
    """A square matrix plus ``amount`` on its diagonal."""
    if not is_sparse(matrix):
        return matrix + amount * np.eye(matrix.shape[0])
    import scipy.sparse as sp

    return matrix + amount * sp.eye_array(matrix.shape[0])


def column_major(matrix: Matrix) -> Any:
    """The same in the order of columns: a ``csc_matrix``, or an array in Fortran's order."""
    if not is_sparse(matrix):
        return np.asfortranarray(matrix)
    import scipy.sparse as sp

    return sp.csc_matrix(matrix)


def dense(matrix: Matrix) -> FloatArray:
    """The same as a plain array."""
    plain: FloatArray = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
    return plain


def split_convex(hessian: FloatArray) -> tuple[FloatArray, FloatArray | None]:
    """Convex part and minus the concave part of a matrix, None where there is none."""
    if not np.any(hessian):
        return hessian, None
    values, vectors = np.linalg.eigh(hessian)
    if values[0] >= -CONCAVE * max(1.0, abs(values[-1])) * len(values):
        return hessian, None
    concave = (vectors * np.maximum(-values, 0.0)) @ vectors.T
    convex = hessian + concave
    return 0.5 * (convex + convex.T), 0.5 * (concave + concave.T)
