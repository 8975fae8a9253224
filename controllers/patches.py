"""Contact patches: the few points through which a controller thinks of the ground.

The simulator resolves every touching node; the controller sees, for each named region, one point
with the mean velocity of the nodes that touch. While none of a region's nodes touches, its lowest
node stands for it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from warp_softbody.arrays import FloatArray
from warp_softbody.body.directional_friction import DIRECTIONS, factors_at
from warp_softbody.body.mesh import TetMesh
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import Value, unchecked
from warp_softbody.world.ground import Ground
from warp_softbody.world.view import BodyView

IntArray = npt.NDArray[np.int32]

FORCE_ANGLES = np.pi + 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
"""Of the sliding that each direction of the force opposes, rad from tangent 1."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Patch(Value):
    """One contact of the control problem.

    Attributes:
        weights: (n,), nodal weights of its point, sum one.
        gap: m, its signed distance from the ground.
        frame: (3, 3), rows normal, tangent 1, tangent 2.
        friction: Coulomb coefficient.
        touching: whether any node of it touched in the last step.
        area: its share of the area that touches; nan where patches are not weighed by area.
        part: of the surface, which stays the same from step to step; None where it has none.
        slips: whether the QPCC is to count on no friction here. The static-contact baseline holds
            it still like every other contact.
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
    slips: bool = False

    def __post_init__(self) -> None:
        """Refuse what is no contact; numbers that are not finite are left to whoever uses them."""
        checks.keep(
            self,
            weights=array_checks.array("Patch.weights", self.weights, (None,), finite=False),
            gap=checks.number("Patch.gap", self.gap, unit="m"),
            frame=array_checks.array("Patch.frame", self.frame, (3, 3), finite=False),
            friction=checks.number("Patch.friction", self.friction, low=0.0),
            touching=checks.truth("Patch.touching", self.touching),
            factors=array_checks.array("Patch.factors", self.factors, (DIRECTIONS,), finite=False),
            slips=checks.truth("Patch.slips", self.slips),
        )
        if self.part is not None:
            checks.keep(self, part=checks.whole("Patch.part", self.part))
        if not (isinstance(self.area, float) and math.isnan(self.area)):
            checks.keep(self, area=checks.number("Patch.area", self.area, low=0.0))

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


class Group(NamedTuple):
    """Nodes (k,) of a patch, with gaps (k,) m and normals (k, 3) as the ground measures them.

    ``shares`` (k,), sum one, weigh the nodes in every mean; None for all alike.
    """

    nodes: IntArray
    gaps: FloatArray
    normals: FloatArray
    shares: FloatArray | None = None


def ground_patches(view: BodyView, regions: tuple[str, ...]) -> tuple[Patch, ...]:
    """One patch for each named region of the character; none where the scene has no ground."""
    checks.instance("view of ground_patches", view, BodyView)
    regions = input_kinds.names("regions of ground_patches", regions)
    ground = view.scene.ground
    if ground is None:
        return ()
    nodes = [view.scene.character.region(name) for name in regions]
    for name, own in zip(regions, nodes, strict=True):
        if not len(own):
            raise InputError(f"patch region {name!r} holds no nodes")
    return patches_of(view, ground, [_standing(view, ground, own) for own in nodes])


def _standing(view: BodyView, ground: Ground, nodes: IntArray) -> Group:
    """Those nodes of a region that stand for it."""
    gaps, normals = ground.measure(view.positions[nodes])
    touching = view.touching[nodes]
    chosen = touching if touching.any() else gaps <= gaps.min() + 1e-9
    return Group(nodes[chosen], gaps[chosen], normals[chosen])


def patches_of(view: BodyView, ground: Ground, groups: Sequence[Group]) -> tuple[Patch, ...]:
    """One patch for each group of nodes."""
    frames = [contact_frame(_mean_direction(group)) for group in groups]
    factors = _force_factors(view, groups, frames)
    return tuple(
        _patch(view, ground, group, frame, own)
        for group, frame, own in zip(groups, frames, factors, strict=True)
    )


def _patch(
    view: BodyView, ground: Ground, group: Group, frame: FloatArray, factors: FloatArray
) -> Patch:
    patch = unchecked(
        Patch,
        weights=_weights(view, group),
        gap=float(group.gaps.mean() if group.shares is None else group.shares @ group.gaps),
        frame=frame,
        friction=ground.friction,
        touching=bool(view.touching[group.nodes].any()),
        factors=factors,
        area=math.nan,
        part=None,
        slips=False,
    )
    # a ground that is not ours, or a body far away
    odd = not (math.isfinite(patch.gap) and 0.0 <= patch.friction < math.inf)
    return replace(patch) if odd else patch


def _weights(view: BodyView, group: Group) -> FloatArray:
    weights = np.zeros(view.node_count)
    weights[group.nodes] = 1.0 / len(group.nodes) if group.shares is None else group.shares
    return weights


def _mean_direction(group: Group) -> tuple[float, float, float]:
    """Unit mean of the normals; the first itself where all are the same, to the last bit."""
    vectors, shares = group.normals, group.shares
    mean = vectors[0]
    if (vectors != mean).any():
        mean = vectors.mean(axis=0) if shares is None else shares @ vectors
        mean = mean / np.linalg.norm(mean)
    x, y, z = mean.tolist()
    return x, y, z


def _force_factors(
    view: BodyView, groups: Sequence[Group], frames: Sequence[FloatArray]
) -> list[FloatArray]:
    """Factors of each patch by the direction of the force, which opposes the sliding."""
    character = view.scene.character
    if not groups or not character.directional_friction:
        return [np.ones(DIRECTIONS) for _ in groups]
    by_node = character.node_friction
    nodes = np.concatenate([group.nodes for group in groups])
    counts = np.array([len(group.nodes) for group in groups])
    begins = np.cumsum(counts) - counts
    carried = (_carrier(character.mesh, by_node.forward.tobytes()) @ view.positions)[nodes]
    tangents = np.repeat([frame[1:] for frame in frames], counts, axis=0)
    ahead = (tangents @ carried[:, :, None])[:, :, 0]
    forward = np.arctan2(ahead[:, 1], ahead[:, 0])
    factors = factors_at(by_node.factors[nodes], FORCE_ANGLES - forward[:, None])
    shares = np.concatenate(
        [np.ones(len(g.nodes)) if g.shares is None else g.shares for g in groups]
    )
    means = np.add.reduceat(factors * shares[:, None], begins)
    means /= np.add.reduceat(shares, begins)[:, None]
    return list(means)


@lru_cache(maxsize=8)
def _carrier(mesh: TetMesh, directions: bytes) -> sp.csr_array:
    """Matrix (n, n) that takes positions to the directions (n, 3) that each node carries.

    They are turned with the mean deformation gradient of the tets around a node, which is linear
    in the positions.
    """
    forward = np.frombuffer(directions).reshape(-1, 3)
    corners = mesh.points[mesh.tets]
    inverse = np.linalg.inv(corners[:, 1:] - corners[:, :1])
    nodes = mesh.tets.ravel()
    around = np.bincount(nodes, minlength=len(mesh.points))
    # One row of four weights on a tet's corners for each of its corners.
    edges = np.einsum("tci,tij->tcj", forward[mesh.tets], inverse)
    weights = np.concatenate([-edges.sum(axis=2, keepdims=True), edges], axis=2)
    weights /= around[mesh.tets][:, :, None]
    rows, columns = np.repeat(nodes, 4), np.repeat(mesh.tets, 4, axis=0).ravel()
    size = (len(mesh.points), len(mesh.points))
    return sp.csr_array((weights.ravel(), (rows, columns)), shape=size)
