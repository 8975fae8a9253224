"""A motion of points as a few fixed displacements with weights from 0 to 1, to a tolerance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray


class Components(NamedTuple):
    """Points are ``base + sum_j weights[f, j] targets[j]``.

    Attributes:
        base: (k, 3) m.
        targets: (c, k, 3) m.
        weights: (f, c), from 0 to 1.
    """

    base: FloatArray
    targets: FloatArray
    weights: FloatArray

    def points(self) -> FloatArray:
        """(f, k, 3) m, what they come to."""
        return np.asarray(self.base + np.einsum("fc,ckd->fkd", self.weights, self.targets))


def components_of(points: FloatArray, tolerance: float) -> Components:
    """The fewest principal components with which no point (f, k, 3) is off by more, m."""
    count = points.shape[1]
    flat = points.reshape(len(points), -1)
    mean = flat.mean(axis=0)
    left, sizes, right = np.linalg.svd(flat - mean, full_matrices=False)
    scores = left * sizes
    off, rank = flat - mean, 0
    while rank < len(sizes) and _largest(off) > tolerance:
        off -= np.outer(scores[:, rank], right[rank])
        rank += 1
    low, high = scores[:, :rank].min(axis=0), scores[:, :rank].max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    base = mean + low @ right[:rank]
    targets = span[:, None] * right[:rank]
    weights = np.clip((scores[:, :rank] - low) / span, 0.0, 1.0)
    return Components(base.reshape(count, 3), targets.reshape(rank, count, 3), weights)


def _largest(off: FloatArray) -> float:
    """The largest length of rows of points (f, 3 k)."""
    return float(np.linalg.norm(off.reshape(len(off), -1, 3), axis=2).max())
