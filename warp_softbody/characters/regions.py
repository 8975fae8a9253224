"""Several characters share these regions: node indices chosen by rest position."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.characters.fibers import QUADRANTS

IntArray = npt.NDArray[np.int32]

EDGE = 1e-6
"""m: nodes nearer than this to a border belong to it, and to both sides of it."""


def select(masks: Mapping[str, BoolArray]) -> dict[str, IntArray]:
    """Node indices of masks over all nodes."""
    return {name: np.flatnonzero(mask).astype(np.int32) for name, mask in masks.items()}


def quadrants(name: str, mesh: TetMesh, within: BoolArray) -> dict[str, BoolArray]:
    """Parts `NAME_0` to `NAME_3` of a mask: x and y of signs --, +-, -+, ++."""
    x, y, _ = mesh.points.T
    return {
        f"{name}_{i}": within & (side_x * x > -EDGE) & (side_y * y > -EDGE)
        for i, (side_x, side_y) in enumerate(QUADRANTS)
    }


def standing(mesh: TetMesh, *, head: float) -> dict[str, BoolArray]:
    """`base` and its quadrants `base_patch_0` to `_3`, `head` from a height on, `head_top`."""
    z = mesh.points[:, 2]
    base = z < EDGE
    masks = {"base": base, "head": z > head - EDGE, "head_top": z > z.max() - EDGE}
    return masks | quadrants("base_patch", mesh, base)
