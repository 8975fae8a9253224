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

JOINED = 0.1
"""Height, over the body's, up to which skin joins pieces of a base to one foot: a ring that lies
touches the floor at a circle of single nodes."""

LEAST_TIPS = 3
"""Limbs that lie on the floor of a body that is said to have feet."""

LOW_AXIS = 2.0
"""Radii of a limb above the floor up to which all of its axis is where it lies. Pieces of its base
say nothing then: where round limbs meet the floor they are bumps of the mesh."""

SECTORS, ROUND, RIM = 12, 0.85, 0.8
"""Sectors about y, the least reach of one over the greatest in which a body is round, and the share
of it from which on skin is of the rim."""

QUADRANTS = ((-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0))
"""Signs of x and y, in the order of the patches of a base and of the fibres around a limb."""


def shape_regions(mesh: TetMesh, limbs: Sequence[Limb]) -> dict[str, IntArray]:
    """Regions by name of a body that stands on z = 0.

    `base` is what may touch the floor; `foot_0`, ... the undersides of the outer halves of three
    limbs or more that lie, else its pieces where there are several, in order around the middle;
    `base_patch_0` to `_3` its quadrants about its middle (x and y: --, +-, -+, ++); `head` the
    upper tenth and `head_top` its skin's top; `limb_0`, ... the limbs that end in a tip, longest
    first; `rim` the outer skin of a body that is round about y.
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
        **_feet(mesh, base, limbs),
        **_rim(mesh, skin),
        **_quadrants(mesh, base),
    }
    regions = {name: np.flatnonzero(mask).astype(np.int32) for name, mask in masks.items()}
    tips = (limb for limb in limbs if limb.ends)
    return regions | {f"limb_{k}": limb.nodes.astype(np.int32) for k, limb in enumerate(tips)}


def _feet(mesh: TetMesh, base: BoolArray, limbs: Sequence[Limb]) -> dict[str, BoolArray]:
    """Pieces of the base, else the outer parts of limbs that lie on it, around its middle."""
    feet = _lying_tips(mesh, base, limbs) or _pieces(mesh, base) or _tips(mesh, base, limbs)
    middle = mesh.points[base, :2].mean(axis=0)
    feet.sort(key=lambda mask: _angle(mesh.points[mask, :2].mean(axis=0) - middle))
    return {f"foot_{k}": mask for k, mask in enumerate(feet)}


def _pieces(mesh: TetMesh, base: BoolArray) -> list[BoolArray]:
    """Pieces of the base that hang together by low skin; none of a single one."""
    edges = mesh.surface[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    low = mesh.points[:, 2] < JOINED * float(mesh.points[:, 2].max())
    edges = edges[low[edges].all(axis=1)]
    count = len(mesh.points)
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(count, count))
    piece = connected_components(graph, directed=False)[1]
    numbers = np.unique(piece[base])
    if not 2 <= len(numbers) <= MOST_FEET:
        return []
    return [base & (piece == number) for number in numbers]


def _lying_tips(mesh: TetMesh, base: BoolArray, limbs: Sequence[Limb]) -> list[BoolArray]:
    """Undersides of the outer halves of limbs that lie along the floor, of three or more."""
    skin = np.zeros(len(base), dtype=bool)
    skin[mesh.surface_nodes] = True
    lying = [limb for limb in limbs if limb.axis[:, 2].max() < LOW_AXIS * limb.radius]
    under = skin & (mesh.points[:, 2] < max((limb.radius for limb in lying), default=0.0))
    return _tips(mesh, base | under, lying)


def _tips(mesh: TetMesh, low: BoolArray, limbs: Sequence[Limb]) -> list[BoolArray]:
    """The outer halves of the low skin of limbs, where there are three of them or more."""
    away = np.linalg.norm(mesh.points[:, :2] - mesh.points[low, :2].mean(axis=0), axis=1)
    tips = []
    for limb in limbs:
        own = np.zeros(len(low), dtype=bool)
        own[limb.nodes] = low[limb.nodes]
        if limb.ends and own.any():
            tips.append(own & (away >= 0.5 * away[own].max()))
    return tips if LEAST_TIPS <= len(tips) <= MOST_FEET else []


def _rim(mesh: TetMesh, skin: BoolArray) -> dict[str, BoolArray]:
    """The outer skin of a body that is as far from its middle in all directions across y."""
    x, z = mesh.points[skin][:, [0, 2]].T
    x, z = x - 0.5 * (x.min() + x.max()), z - 0.5 * (z.min() + z.max())
    away = np.hypot(x, z)
    sector = np.floor(SECTORS * (np.arctan2(z, x) / (2.0 * np.pi) + 0.5)).astype(int) % SECTORS
    reach = np.zeros(SECTORS)
    np.maximum.at(reach, sector, away)
    if reach.min() < ROUND * reach.max():
        return {}
    rim = np.zeros(len(skin), dtype=bool)
    rim[np.flatnonzero(skin)] = away > RIM * reach.max()
    return {"rim": rim}


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
