"""Contact patches: the few points through which a controller thinks of the ground.

The simulator resolves every touching node; the controller sees, for each named region, one point
with the mean velocity of the nodes that touch. While none of a region's nodes touches, its lowest
node stands for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError
from warp_softbody.ground import Plane
from warp_softbody.view import BodyView

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Patch:
    """One contact of the control problem.

    Attributes:
        weights: (n,), nodal weights of its point, sum one.
        gap: m, its signed distance from the ground.
        frame: (3, 3), rows normal, tangent 1, tangent 2.
        friction: Coulomb coefficient.
        touching: whether any node of it touched in the last step.
    """

    weights: FloatArray
    gap: float
    frame: FloatArray
    friction: float
    touching: bool

    def rows(self) -> FloatArray:
        """Velocity of the patch in its own frame, (3, 3n)."""
        return (self.frame[:, None, :] * self.weights[:, None]).reshape(3, -1)


@cache
def contact_frame(normal: tuple[float, float, float]) -> FloatArray:
    """Rows normal, tangent 1, tangent 2: right-handed, tangent 1 along x where possible."""
    n = np.array(normal)
    axis = np.array([1.0, 0.0, 0.0]) if abs(n[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = axis - (axis @ n) * n
    first /= np.linalg.norm(first)
    frame = np.stack([n, first, np.cross(n, first)])
    frame.setflags(write=False)
    return frame


def ground_patches(view: BodyView, regions: tuple[str, ...]) -> tuple[Patch, ...]:
    """One patch for each named region of the character; none where the scene has no ground."""
    ground = view.scene.ground
    if ground is None:
        return ()
    return tuple(_patch(view, ground, name) for name in regions)


def _patch(view: BodyView, ground: Plane, region: str) -> Patch:
    nodes = view.scene.character.region(region)
    if not len(nodes):
        raise InputError(f"patch region {region!r} holds no nodes")
    frame = contact_frame(ground.normal)
    gaps = view.positions[nodes] @ frame[0] - ground.offset
    touching = view.touching[nodes]
    chosen = touching if touching.any() else gaps <= gaps.min() + 1e-9
    weights = np.zeros(view.node_count)
    weights[nodes[chosen]] = 1.0 / np.count_nonzero(chosen)
    return Patch(
        weights=weights,
        gap=float(gaps[chosen].mean()),
        frame=frame,
        friction=ground.friction,
        touching=bool(touching.any()),
    )
