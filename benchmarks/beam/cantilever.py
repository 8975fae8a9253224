"""The benchmark body W1: a beam clamped at one end that falls under its own weight."""

from __future__ import annotations

import itertools

import numpy as np

from warp_softbody import TetMesh
from warp_softbody.accuracy.runs.peers.beam import Cantilever

CELLS = {810: 3, 10_290: 7, 51_840: 12}
"""Cells across the beam by number of tets."""

SIZE = (1.0, 0.2, 0.2)
TIME_STEP = 0.01


def cantilever(tets: int) -> Cantilever:
    """The beam of a number of tets out of ``CELLS``."""
    mesh = beam_mesh(CELLS[tets])
    along = mesh.points[:, 0]
    return Cantilever(mesh=mesh, fixed=along < 1e-9, tip=along > SIZE[0] - 1e-9)


def beam_mesh(cells: int) -> TetMesh:
    """A grid of 5 n x n x n cells of six Kuhn tets each."""
    counts = np.array([5 * cells, cells, cells])
    axes = [np.linspace(0.0, size, count + 1) for size, count in zip(SIZE, counts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    strides = np.array([(counts[1] + 1) * (counts[2] + 1), counts[2] + 1, 1])
    tets = []
    for order in itertools.permutations(range(3)):
        path = np.cumsum([np.zeros(3, int), *np.eye(3, dtype=int)[list(order)]], axis=0)
        tets.append((corners[:, None, :] + path) @ strides)
    return TetMesh.from_arrays(points, np.concatenate(tets))
