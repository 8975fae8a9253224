"""Points that lie closer together than a tolerance are merged into one."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Numbers = npt.NDArray[np.int64]

MOST_ROUNDS = 20
"""Rounds of cutting groups along the axes; two or three do unless points are placed against it."""


def first_of_close(points: npt.NDArray[np.float64], tolerance: float) -> Numbers:
    """For each of n points (n, 3), the lowest index of the points that it is one with.

    Points are one when chains of steps of at most `tolerance` m join them along each axis. Sorting
    needs memory in proportion to n, while the pairs of many points at one place grow with n^2.
    """
    group = np.zeros(len(points), dtype=np.int64)
    count = 0
    for _ in range(MOST_ROUNDS):
        for axis in range(3):
            group = _split(group, points[:, axis], tolerance)
        found = int(group.max(initial=-1)) + 1
        if found == count:
            break
        count = found
    _, first = np.unique(group, return_index=True)
    return first[group].astype(np.int64)


def _split(group: Numbers, coordinate: npt.NDArray[np.float64], tolerance: float) -> Numbers:
    """Numbers of the groups after each is cut where its coordinates leave a gap."""
    order = np.lexsort((coordinate, group))
    ordered, along = group[order], coordinate[order]
    cut = np.ones(len(order), dtype=np.int64)
    cut[1:] = (ordered[1:] != ordered[:-1]) | (np.diff(along) > tolerance)
    result = np.empty_like(group)
    result[order] = np.cumsum(cut) - 1
    return result
