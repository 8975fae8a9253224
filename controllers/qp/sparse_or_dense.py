"""Matrices that are sparse where that pays (large problems with few entries), and dense elsewhere.

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
"""Share of entries that are not zero, below which a large problem is kept sparse."""


def sparse_where_worthwhile(*matrices: FloatArray, above: int = SPARSE_SIZE) -> tuple[Matrix, ...]:
    """The matrices of one problem, all sparse or all as they are.

    They become sparse with more than ``above`` columns, if few of their entries are not zero.
    """
    entries = sum(int(np.count_nonzero(matrix)) for matrix in matrices)
    small = matrices[0].shape[1] <= above
    if small or entries >= SPARSE_FILL * sum(matrix.size for matrix in matrices):
        return matrices
    import scipy.sparse as sp

    return tuple(sp.csr_array(matrix) for matrix in matrices)


def is_sparse(matrix: Matrix) -> bool:
    """Whether a matrix is kept sparse."""
    return not isinstance(matrix, np.ndarray)


def stack_rows(parts: Sequence[Matrix]) -> Matrix:
    """Matrices one below the other; the result is sparse if the first one is."""
    if not is_sparse(parts[0]):
        return np.concatenate(parts)
    import scipy.sparse as sp

    return sp.vstack(parts, format="csr")


def add_to_diagonal(matrix: Matrix, amount: float) -> Matrix:
    """A square matrix plus ``amount`` on its diagonal."""
    if not is_sparse(matrix):
        return matrix + amount * np.eye(matrix.shape[0])
    import scipy.sparse as sp

    return matrix + amount * sp.eye_array(matrix.shape[0])


def column_major(matrix: Matrix) -> Any:
    """The matrix stored by columns: a ``csc_matrix``, or an array in Fortran's order."""
    if not is_sparse(matrix):
        return np.asfortranarray(matrix)
    import scipy.sparse as sp

    return sp.csc_matrix(matrix)


def to_dense(matrix: Matrix) -> FloatArray:
    """The matrix as an array."""
    plain: FloatArray = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
    return plain
