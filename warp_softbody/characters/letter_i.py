"""The letter I: a stem on a base, with a head like the base; the character that balances."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warp_softbody.character import Character
from warp_softbody.characters.store import load_mesh, load_recipe
from warp_softbody.muscles import Fiber, FiberKind, MuscleGroup

if TYPE_CHECKING:
    import trimesh

FIBER_OFFSET = 0.12
FIBER_ENDS = (0.02, 0.98)
SEGMENTS = 12
STRENGTH = 4e5
KERNEL_WIDTH = 0.12
HEAD_HEIGHT = 0.9
EDGE = 1e-6


def letter_i() -> Character:
    """Letter I, 1 m high on z = 0 and centred on the z axis, with four longitudinal fibres.

    Base and head are 0.5 (x) by 0.3 (y) by 0.1 (z) m, the stem between them 0.3 by 0.3 m.
    Regions: the underside `base`, its quadrants `base_patch_0` to `base_patch_3` (x and y: --,
    +-, -+, ++; nodes on x = 0 or y = 0 belong to both sides), the `head` and its upper face
    `head_top`.
    """
    mesh = load_mesh("letter_i")
    x, y, z = mesh.points.T
    base = np.flatnonzero(z < EDGE)
    regions = {
        "base": base,
        "head": np.flatnonzero(z > HEAD_HEIGHT - EDGE),
        "head_top": np.flatnonzero(z > z.max() - EDGE),
    }
    for patch in range(4):
        side_x, side_y = _quadrant(patch)
        inside = (side_x * x[base] > -EDGE) & (side_y * y[base] > -EDGE)
        regions[f"base_patch_{patch}"] = base[inside]
    return Character(
        name="letter_i",
        mesh=mesh,
        muscles=(_longitudinal(),),
        regions={name: nodes.astype(np.int32) for name, nodes in regions.items()},
    )


def letter_i_surface() -> trimesh.Trimesh:
    """Closed surface of the letter, as a user's own file would hold it."""
    return load_recipe("letter_i").surface()


def _quadrant(index: int) -> tuple[float, float]:
    """Signs of x and y in a quadrant: --, +-, -+, ++."""
    return (1.0 if index % 2 else -1.0), (1.0 if index // 2 else -1.0)


def _longitudinal() -> MuscleGroup:
    """Four vertical fibres, one near each corner of the stem."""
    return MuscleGroup(
        fibers=tuple(
            Fiber(
                vertices=_vertical(*(FIBER_OFFSET * side for side in _quadrant(i))),
                kind=FiberKind.LONGITUDINAL,
                name=f"longitudinal_{i}",
            )
            for i in range(4)
        ),
        strength=STRENGTH,
        kernel_width=KERNEL_WIDTH,
        name="longitudinal",
    )


def _vertical(x: float, y: float) -> npt.NDArray[np.float64]:
    heights = np.linspace(*FIBER_ENDS, SEGMENTS + 1)
    return np.stack([np.full_like(heights, x), np.full_like(heights, y), heights], axis=1)
