"""The benchmark body W1: a beam clamped at one end that falls under its own weight."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody import Material, TetMesh
from warp_softbody.arrays import FloatArray

CELLS = {810: 3, 10_290: 7, 51_840: 12}
"""Cells across the beam by number of tets."""

SIZE = (1.0, 0.2, 0.2)
TIME_STEP = 0.01
GRAVITY = 9.81
MATERIAL = Material(
    young_modulus=1e6, poisson_ratio=0.4, density=1000.0, stiffness_damping=0.0, mass_damping=0.0
)


@dataclass(frozen=True, kw_only=True)
class Cantilever:
    """A mesh with its clamped and its tip face.

    Attributes:
        mesh: the straight beam along x.
        fixed: (n,) whether a node is clamped.
        tip: (n,) whether a node is on the free end face.
    """

    mesh: TetMesh
    fixed: npt.NDArray[np.bool_]
    tip: npt.NDArray[np.bool_]

    def fall(self, positions: FloatArray) -> float:
        """Mean fall of the tip face, m."""
        return float((self.mesh.points - positions)[self.tip, 2].mean())


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
