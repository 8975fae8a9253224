"""A body-centred cubic lattice over cubes of several sizes (Labelle and Shewchuk, 2007, section 3).

Between two cubes of a size are four tets about the edges of their common face, cut in two where an
edge has a node in its middle. Where four smaller cubes share a cube's face, eight tets join its
centre to the triangles about the face's centre; on the smaller side two tets each meet them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.body.making.octree import LEVELS, UNIT, Leaves, Numbers, Octree, codes

SQUARE = np.array([[1, 0], [1, 1], [0, 1], [0, 0]])
"""Corners of a face, in order around it."""


class Lattice(NamedTuple):
    """Nodes (n, 3) m and tets (m, 4) of a lattice, of either sign."""

    nodes: FloatArray
    tets: Numbers


def graded_lattice(tree: Octree) -> Lattice:
    """The lattice over the leaves of an octree, up to the centres of its outermost cubes."""
    leaves = tree.leaves()
    corners = np.unique(codes(np.concatenate([_corners(leaves, k) for k in range(LEVELS + 1)])))
    tets = np.concatenate(
        [
            part
            for level, cubes in enumerate(leaves.cubes)
            if len(cubes)
            for axis in range(3)
            for side in (0, 1)
            for part in _tets_at_faces(tree, leaves, level, axis, side, corners)
        ]
    )
    places, numbers = np.unique(codes(tets.reshape(-1, 3)), return_inverse=True)
    # corners before centres: the lowest of equal nodes is moved first
    order = np.argsort(~np.isin(places, corners), kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    places = places[order]
    steps = np.stack([places >> 42, places >> 21, places], axis=1) & ((1 << 21) - 1)
    nodes = (steps - (1 << 20)) / UNIT * tree.spacing + tree.origin
    return Lattice(nodes, rank[numbers].reshape(-1, 4))


def _corners(leaves: Leaves, level: int) -> Numbers:
    """Corners (k, 3) of a level's leaves, in units."""
    size = UNIT >> level
    around = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
    corners: Numbers = ((leaves.cubes[level][:, None] + around) * size).reshape(-1, 3)
    return corners


def _tets_at_faces(
    tree: Octree, leaves: Leaves, level: int, axis: int, side: int, corners: Numbers
) -> list[Numbers]:
    """Tets (k, 4, 3), in units, of a level's leaves at their lower or upper face along an axis."""
    size, cubes = UNIT >> level, leaves.cubes[level]
    step = np.eye(3, dtype=np.int64)[axis] * (2 * side - 1)
    beyond = cubes + step
    within = ((beyond >= 0) & (beyond < leaves.counts << level)).all(axis=1)
    alike, finer = leaves.among(level, beyond), tree.split(level, beyond)
    coarser = within & ~alike & ~finer
    found = [_about_quarters(*_face(cubes[finer], size, axis, side))]
    if side:
        centres, face = _face(cubes[alike], size, axis, side)
        found += _about_edges(centres, centres + step * size, face, corners)
    centres, face = _face(cubes[coarser], size, axis, side)
    found.append(_about_halves(centres, face, axis, size))
    return found


def _face(cubes: Numbers, size: int, axis: int, side: int) -> tuple[Numbers, Numbers]:
    """Centres (k, 3) of cubes and the corners (k, 4, 3) of one of their faces, in units."""
    corners = np.zeros((4, 3), dtype=np.int64)
    corners[:, axis] = side
    corners[:, [(axis + 1) % 3, (axis + 2) % 3]] = SQUARE
    return cubes * size + size // 2, (cubes[:, None] + corners) * size


def _about_edges(
    centres: Numbers, others: Numbers, face: Numbers, corners: Numbers
) -> list[Numbers]:
    """Tets of two centres and each edge of the face between them, in two if it has a middle."""
    found = []
    for k in range(4):
        start, end = face[:, k], face[:, (k + 1) % 4]
        middle = (start + end) // 2
        cut: BoolArray = np.isin(codes(middle), corners)
        whole = ~cut
        found += [
            np.stack([centres[whole], others[whole], start[whole], end[whole]], axis=1),
            np.stack([centres[cut], others[cut], start[cut], middle[cut]], axis=1),
            np.stack([centres[cut], others[cut], middle[cut], end[cut]], axis=1),
        ]
    return found


def _about_quarters(centres: Numbers, face: Numbers) -> Numbers:
    """Tets of a centre and the eight triangles about the middle of a face."""
    middle = face.sum(axis=1) // 4
    found = []
    for k in range(4):
        corner = face[:, k]
        for other in (face[:, (k + 1) % 4], face[:, k - 1]):
            found.append(np.stack([centres, middle, (corner + other) // 2, corner], axis=1))
    return np.concatenate(found)


def _about_halves(centres: Numbers, face: Numbers, axis: int, size: int) -> Numbers:
    """Tets of a centre and both halves of a face that is a quarter of a larger cube's.

    Its diagonal starts at the middle of the larger face, whose coordinates are odd in small cubes.
    """
    along = [(axis + 1) % 3, (axis + 2) % 3]
    odd = (face[:, :, along] // size % 2 == 1).all(axis=2)
    first = odd.argmax(axis=1)
    rows = np.arange(len(face))
    a, b, c, d = (face[rows, (first + k) % 4] for k in range(4))
    halves = [np.stack([centres, a, c, b], axis=1), np.stack([centres, a, c, d], axis=1)]
    return np.concatenate(halves)
