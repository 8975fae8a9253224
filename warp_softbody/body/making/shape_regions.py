"""Regions of a body by its shape: what it stands on, its head and its limbs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from warp_softbody.arrays import BoolArray
from warp_softbody.body.making.limbs import Limb
from warp_softbody.body.mesh import TetMesh

IntArray = npt.NDArray[np.int32]

SOLE = 0.03
"""Height, over the body's, up to which a node of the skin may touch the floor."""

HEAD = 0.9
"""Height, over the body's, from which on a node is of the head."""

MOST_FEET = 8
"""Feet that are told apart; a body on more pieces stands on its base as a whole."""

QUADRANTS = ((-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0))
"""Signs of x and y, in the order of the patches of a base and of the fibres around a limb."""


def shape_regions(mesh: TetMesh, limbs: Sequence[Limb]) -> dict[str, IntArray]:
    """Regions by name of a body that stands on z = 0.

    `base` is what may touch the floor; `foot_0`, ... its pieces where there are several, in order
    around the middle; `base_patch_0` to `_3` its quadrants about its middle (x and y: --, +-, -+,
    ++); `head` the upper tenth and `head_top` its skin's top; `limb_0`, ... the limbs that end in a
    tip, longest first.
    """
    height = float(mesh.points[:, 2].max())
    skin = np.zeros(len(mesh.points), dtype=bool)
    skin[mesh.surface_nodes] = True
    z = mesh.points[:, 2]
    base = skin & (z < SOLE * height)
    masks = {
        "base": base,
        "head": z > HEAD * height,
        "head_top": skin & (z > (1.0 - SOLE) * height),
        **_feet(mesh, base),
        **_quadrants(mesh, base),
    }
    regions = {name: np.flatnonzero(mask).astype(np.int32) for name, mask in masks.items()}
    tips = (limb for limb in limbs if limb.ends)
    return regions | {f"limb_{k}": limb.nodes.astype(np.int32) for k, limb in enumerate(tips)}


def _feet(mesh: TetMesh, base: BoolArray) -> dict[str, BoolArray]:
    """Pieces of the base that hang together along edges of the skin."""
    edges = mesh.surface[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges = edges[base[edges].all(axis=1)]
    count = len(mesh.points)
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(count, count))
    piece = connected_components(graph, directed=False)[1]
    numbers = np.unique(piece[base])
    if not 2 <= len(numbers) <= MOST_FEET:
        return {}
    pieces = [base & (piece == number) for number in numbers]
    middle = mesh.points[base, :2].mean(axis=0)
    pieces.sort(key=lambda mask: _angle(mesh.points[mask, :2].mean(axis=0) - middle))
    return {f"foot_{k}": mask for k, mask in enumerate(pieces)}


def _angle(way: npt.NDArray[np.float64]) -> float:
    """Angle about the vertical from -x, rounded so that mirror images keep their order."""
    return round(float(np.arctan2(way[1], way[0])), 6)


def _quadrants(mesh: TetMesh, base: BoolArray) -> dict[str, BoolArray]:
    ends = mesh.points[base, :2]
    x, y = (mesh.points[:, :2] - 0.5 * (ends.min(axis=0) + ends.max(axis=0))).T
    edge = 1e-6 * float(np.ptp(ends, axis=0).max())
    return {
        f"base_patch_{k}": base & (sign_x * x > -edge) & (sign_y * y > -edge)
        for k, (sign_x, sign_y) in enumerate(QUADRANTS)
    }
