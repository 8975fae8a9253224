"""Contact patches: the few points through which a controller thinks of the ground.

The simulator resolves every touching node; the controller sees, for each named region, one point
with the mean velocity of the nodes that touch. While none of a region's nodes touches, its lowest
node stands for it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError
from warp_softbody.ground import Ground
from warp_softbody.ground_friction import DIRECTIONS, factors_at
from warp_softbody.mesh import TetMesh
from warp_softbody.view import BodyView

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class Patch:
    """One contact of the control problem.

    Attributes:
        weights: (n,), nodal weights of its point, sum one.
        gap: m, its signed distance from the ground.
        frame: (3, 3), rows normal, tangent 1, tangent 2.
        friction: Coulomb coefficient.
        touching: whether any node of it touched in the last step.
        area: its share of the area that touches; nan where patches are not weighed by area.
        part: of the surface, which stays the same from step to step; None where it has none.
        factors: (8,) on the friction, for forces along directions evenly spread from tangent 1
            towards tangent 2; ones unless the character has directional friction.
    """

    weights: FloatArray
    gap: float
    frame: FloatArray
    friction: float
    touching: bool
    factors: FloatArray = field(default_factory=lambda: np.ones(DIRECTIONS))
    area: float = math.nan
    part: int | None = None

    def rows(self) -> FloatArray:
        """Velocity of the patch in its own frame, (3, 3n)."""
        return (self.frame[:, None, :] * self.weights[:, None]).reshape(3, -1)


@lru_cache(maxsize=64)
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


def _patch(view: BodyView, ground: Ground, region: str) -> Patch:
    nodes = view.scene.character.region(region)
    if not len(nodes):
        raise InputError(f"patch region {region!r} holds no nodes")
    gaps, normals = ground.measure(view.positions[nodes])
    touching = view.touching[nodes]
    chosen = touching if touching.any() else gaps <= gaps.min() + 1e-9
    return patch_of(view, ground, nodes[chosen], gaps[chosen], normals[chosen])


def patch_of(
    view: BodyView,
    ground: Ground,
    nodes: IntArray,
    gaps: FloatArray,
    normals: FloatArray,
    shares: FloatArray | None = None,
) -> Patch:
    """The patch of nodes (k,) with gaps (k,) m and normals (k, 3), as the ground measures them.

    ``shares`` (k,), sum one, weigh the nodes in every mean; default all alike.
    """
    frame = contact_frame(_mean_direction(normals, shares))
    weights = np.zeros(view.node_count)
    weights[nodes] = 1.0 / len(nodes) if shares is None else shares
    return Patch(
        weights=weights,
        gap=float(gaps.mean() if shares is None else shares @ gaps),
        frame=frame,
        friction=ground.friction,
        touching=bool(view.touching[nodes].any()),
        factors=_force_factors(view, nodes, frame, shares),
    )


def _mean_direction(vectors: FloatArray, shares: FloatArray | None) -> tuple[float, float, float]:
    """Unit mean of vectors (k, 3); the first itself where all are the same, to the last bit."""
    mean = vectors[0]
    if (vectors != mean).any():
        mean = vectors.mean(axis=0) if shares is None else shares @ vectors
        mean = mean / np.linalg.norm(mean)
    x, y, z = mean.tolist()
    return x, y, z


def _force_factors(
    view: BodyView, nodes: IntArray, frame: FloatArray, shares: FloatArray | None
) -> FloatArray:
    """Factors of a patch of nodes by the direction of the force, which opposes the sliding."""
    character = view.scene.character
    if not character.directional_friction:
        return np.ones(DIRECTIONS)
    by_node = character.node_friction
    ahead = _carried(view, nodes, by_node.forward[nodes]) @ frame[1:].T
    forward = np.arctan2(ahead[:, 1], ahead[:, 0])
    sliding = np.pi + 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    factors = factors_at(by_node.factors[nodes], sliding - forward[:, None])
    return np.asarray(np.average(factors, axis=0, weights=shares))


@lru_cache(maxsize=8)
def _tets_around(mesh: TetMesh) -> tuple[FloatArray, IntArray, IntArray]:
    """Inverse rest edges (m, 3, 3); tets sorted by the nodes they hold, and where each begins."""
    corners = mesh.points[mesh.tets]
    inverse = np.asarray(np.linalg.inv(corners[:, 1:] - corners[:, :1]), dtype=np.float64)
    nodes = mesh.tets.ravel()
    order = np.argsort(nodes, kind="stable")
    begins = np.searchsorted(nodes[order], np.arange(len(mesh.points) + 1))
    return inverse, (order // 4).astype(np.int32), begins.astype(np.int32)


def _carried(view: BodyView, nodes: IntArray, directions: FloatArray) -> FloatArray:
    """Directions (k, 3) at nodes, turned with the mean deformation gradient around each node."""
    mesh = view.scene.character.mesh
    inverse, order, begins = _tets_around(mesh)
    counts = begins[nodes + 1] - begins[nodes]
    tets = np.concatenate([order[begins[node] : begins[node + 1]] for node in nodes])
    corners = view.positions[mesh.tets[tets]]
    transposed = inverse[tets] @ (corners[:, 1:] - corners[:, :1])
    carried = np.einsum("ti,tij->tj", np.repeat(directions, counts, axis=0), transposed)
    firsts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    return np.asarray(np.add.reduceat(carried, firsts) / counts[:, None])
