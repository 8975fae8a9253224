"""A positive definite matrix that is a diagonal and the squares of few rows."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.linalg import lapack

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.sparse_or_dense import Matrix


class Gram:
    """``diag(d) + N'N``, d (n,) > 0 and N (r, n); knows what a QP asks of its matrix."""

    def __init__(self, diagonal: FloatArray, rows: FloatArray) -> None:
        """Keep both; nothing is multiplied out until asked for."""
        self.diagonal = diagonal
        self.rows = rows

    def __matmul__(self, vector: FloatArray) -> FloatArray:
        """Product with a vector (n,)."""
        product: FloatArray = self.diagonal * vector + (self.rows @ vector) @ self.rows
        return product

    def toarray(self) -> FloatArray:
        """The matrix, (n, n)."""
        whole: FloatArray = self.rows.T @ self.rows
        whole[np.arange(len(whole)), np.arange(len(whole))] += self.diagonal
        return whole

    @cached_property
    def _weighted(self) -> FloatArray:
        """N / d."""
        weighted: FloatArray = self.rows / self.diagonal
        return weighted

    def saved(self, c: FloatArray) -> float:
        """By how much c'x + x'diag(d)x / 2 can be lower than with the squares: a sum over rows."""
        small = self._weighted @ self.rows.T
        small[np.arange(len(small)), np.arange(len(small))] += 1.0
        along = self._weighted @ c
        return 0.5 * float(along @ lapack.dposv(small, along)[1])

    def depth(self, c: FloatArray) -> float:
        """Minus the least of x'Px / 2 + c'x."""
        return 0.5 * float(c @ (c / self.diagonal)) - self.saved(c)


def lowest(matrix: Matrix, c: FloatArray) -> float | None:
    """Minus the least of x'Px / 2 + c'x; None where P is not definite."""
    if isinstance(matrix, Gram):
        return matrix.depth(c)
    _, least, failed = lapack.dposv(matrix, c)
    return None if failed else 0.5 * float(least @ c)
