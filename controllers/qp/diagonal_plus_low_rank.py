"""A positive definite matrix that is a diagonal plus one of low rank."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.linalg import lapack

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.sparse_or_dense import Matrix


class DiagonalPlusLowRank:
    """``diag(d) + N'N`` with d (n,) > 0 and a factor N (r, n), as the Hessian of a QP."""

    def __init__(self, diagonal: FloatArray, factor: FloatArray) -> None:
        """Keep both; nothing is multiplied out until asked for."""
        self.diagonal = diagonal
        self.factor = factor

    def __matmul__(self, vector: FloatArray) -> FloatArray:
        """Product with a vector (n,)."""
        product: FloatArray = self.diagonal * vector + (self.factor @ vector) @ self.factor
        return product

    def toarray(self) -> FloatArray:
        """The matrix, (n, n)."""
        whole: FloatArray = self.factor.T @ self.factor
        whole[np.arange(len(whole)), np.arange(len(whole))] += self.diagonal
        return whole

    @cached_property
    def _weighted(self) -> FloatArray:
        """N / d."""
        weighted: FloatArray = self.factor / self.diagonal
        return weighted

    def low_rank_share(self, c: FloatArray) -> float:
        """By how much N'N raises the unconstrained minimum of c'x + x'Px / 2, >= 0.

        By the Woodbury identity, from a system of r equations.
        """
        small = self._weighted @ self.factor.T
        small[np.arange(len(small)), np.arange(len(small))] += 1.0
        along = self._weighted @ c
        return 0.5 * float(along @ lapack.dposv(small, along)[1])

    def unconstrained_minimum(self, c: FloatArray) -> float:
        """The minimum of c'x + x'Px / 2 over all x."""
        return self.low_rank_share(c) - 0.5 * float(c @ (c / self.diagonal))


def unconstrained_minimum(matrix: Matrix, c: FloatArray) -> float | None:
    """The minimum of c'x + x'Px / 2 over all x; None where P is not positive definite."""
    if isinstance(matrix, DiagonalPlusLowRank):
        return matrix.unconstrained_minimum(c)
    _, minimiser, failed = lapack.dposv(matrix, c)
    return None if failed else -0.5 * float(minimiser @ c)
