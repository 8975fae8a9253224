"""Tets that a surface passes through are cut along it, alike on both sides of each shared face."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.body.mesh_geometry import tet_volumes

Numbers = npt.NDArray[np.int64]

CLOSE = 1e-9
"""Two diagonals whose lengths differ by less than this share are of equal length."""


class Cut(NamedTuple):
    """Points (n, 3) m and tets (m, 4) of positive volume."""

    points: FloatArray
    tets: Numbers


class _Crossings:
    """Points at which edges pass through the surface, each made once."""

    def __init__(self, nodes: FloatArray, inside: FloatArray, tets: Numbers) -> None:
        edges = np.concatenate([tets[:, [a, b]] for a in range(4) for b in range(a)])
        edges = np.unique(np.sort(edges, axis=1), axis=0)
        edges = edges[inside[edges[:, 0]] * inside[edges[:, 1]] < 0.0]
        self._count = len(nodes)
        self._keys = edges[:, 0] * self._count + edges[:, 1]
        one, other = inside[edges].T
        share = (one / (one - other))[:, None]
        places = (1.0 - share) * nodes[edges[:, 0]] + share * nodes[edges[:, 1]]
        self.points = np.concatenate([nodes, places])

    def on(self, one: Numbers, other: Numbers) -> Numbers:
        """Number of the point on each edge (k,), which must pass through the surface."""
        keys = np.minimum(one, other) * self._count + np.maximum(one, other)
        return self._count + np.searchsorted(self._keys, keys)


def cut_tets(nodes: FloatArray, inside: FloatArray, tets: Numbers) -> Cut:
    """Cut tets (m, 4) over nodes (n, 3) m to where the distance (n,) is not negative.

    Points that no tet uses are left out.
    """
    crossings = _Crossings(nodes, inside, tets)
    points = crossings.points
    sign = np.sign(inside[tets])
    order = np.argsort(-sign, axis=1, kind="stable")
    tets = np.take_along_axis(tets, order, axis=1)
    positive, negative = (sign > 0).sum(axis=1), (sign < 0).sum(axis=1)
    kept = [tets[(negative == 0) & (positive > 0)]]
    kept.append(_one_inside(tets[(positive == 1) & (negative > 0)], inside, crossings))
    kept += _pyramids(tets[(positive == 2) & (negative == 1)], points, crossings)
    a, b, c, d = tets[(positive == 2) & (negative == 2)].T
    on = crossings.on
    prisms = [np.stack([a, on(a, c), on(a, d), b, on(b, c), on(b, d)], axis=1)]
    a, b, c, d = tets[(positive == 3) & (negative == 1)].T
    prisms.append(np.stack([a, b, c, on(a, d), on(b, d), on(c, d)], axis=1))
    cut, points = _split_prisms(np.concatenate(prisms), points)
    all_tets = np.concatenate([*kept, *cut])
    used, compact = np.unique(all_tets, return_inverse=True)
    return Cut(points[used], _positive(points[used], compact.reshape(-1, 4)))


def _one_inside(tets: Numbers, inside: FloatArray, crossings: _Crossings) -> Numbers:
    """What is left of tets of which only the first node lies inside."""
    result: Numbers = tets.copy()
    for corner in range(1, 4):
        outside = inside[tets[:, corner]] < 0.0
        result[outside, corner] = crossings.on(tets[outside, 0], tets[outside, corner])
    return result


def _pyramids(tets: Numbers, points: FloatArray, crossings: _Crossings) -> list[Numbers]:
    """What is left of tets with nodes inside, inside, on the surface and outside."""
    a, b, apex, outside = tets.T
    quad = np.stack([a, b, crossings.on(b, outside), crossings.on(a, outside)], axis=1)
    halves = _halves(quad, _first_diagonal(points, quad))
    return [np.column_stack([half, apex]) for half in halves]


HALVES = (([0, 1, 2], [0, 2, 3]), ([1, 2, 3], [1, 3, 0]))
"""Halves of a quadrilateral by its diagonal 0-2, and by 1-3."""

SIDES = ([0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5])
"""Quadrilaterals of a prism between the triangles 0 1 2 and 3 4 5."""

PRISMS = {
    (True, False, False): ([0, 3, 4, 5], [0, 1, 2, 4], [0, 2, 5, 4]),
    (True, True, False): ([0, 3, 4, 5], [0, 1, 2, 5], [0, 1, 5, 4]),
    (False, True, False): ([1, 3, 4, 5], [1, 2, 0, 5], [1, 0, 3, 5]),
    (False, True, True): ([1, 3, 4, 5], [1, 2, 0, 3], [1, 2, 3, 5]),
    (False, False, True): ([2, 3, 4, 5], [2, 0, 1, 3], [2, 1, 4, 3]),
    (True, False, True): ([2, 3, 4, 5], [2, 0, 1, 4], [2, 0, 4, 3]),
}
"""Tets of a prism by which of its sides are cut along their diagonal 0-2."""


def _first_diagonal(points: FloatArray, quad: Numbers) -> BoolArray:
    """Whether the diagonal 0-2 of each quadrilateral (k, 4) is taken, the shorter one.

    Of equal ones it is that of the lowest point, so that both tets at the face take the same.
    """
    first, second = (_length(points, np.sort(quad[:, ends], axis=1)) for ends in ([0, 2], [1, 3]))
    even = np.abs(first - second) <= CLOSE * (first + second)
    return np.where(even, quad.argmin(axis=1) % 2 == 0, first < second)


def _length(points: FloatArray, ends: Numbers) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    return lengths


def _halves(quad: Numbers, first: BoolArray) -> list[Numbers]:
    """Both triangles (k, 3) of each quadrilateral (k, 4)."""
    by_first, by_second = HALVES
    return [
        np.where(first[:, None], quad[:, one], quad[:, other])
        for one, other in zip(by_first, by_second, strict=True)
    ]


def _split_prisms(prisms: Numbers, points: FloatArray) -> tuple[list[Numbers], FloatArray]:
    """Tets of prisms (k, 6), and all points: some prisms get one in their middle.

    Where the three diagonals run round a prism, no three tets fill it; it takes eight.
    """
    first = np.stack([_first_diagonal(points, prisms[:, side]) for side in SIDES], axis=1)
    cut = [
        prisms[(first == pattern).all(axis=1)][:, corners]
        for pattern, tets in PRISMS.items()
        for corners in tets
    ]
    round_it = (first == first[:, :1]).all(axis=1)
    prisms, first = prisms[round_it], first[round_it]
    faces = [prisms[:, :3], prisms[:, 3:]]
    for number, side in enumerate(SIDES):
        faces += _halves(prisms[:, side], first[:, number])
    middle = len(points) + np.arange(len(prisms))
    cut += [np.column_stack([face, middle]) for face in faces]
    return cut, np.concatenate([points, points[prisms].mean(axis=1)])


def _positive(points: FloatArray, tets: Numbers) -> Numbers:
    """The tets, those of negative volume turned."""
    turned = tet_volumes(points, tets.astype(np.int32)) < 0.0
    tets[turned] = tets[turned][:, [0, 1, 3, 2]]
    return tets
