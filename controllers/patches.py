"""Contact patches: the few points through which a controller thinks of the ground.

The simulator resolves every touching node; the controller sees, for each named region, one point
with the mean velocity of what is near the ground, each node by its share of area and of load
(`contact_quadrature`), in a frame along the motion (`contact_frames`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from warp_softbody.arrays import FloatArray
from warp_softbody.body.directional_friction import DIRECTIONS, factors_at
from warp_softbody.body.mesh import TetMesh
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.contact_frames import SLIDING, carried_axes, moving_frame
from warp_softbody.controllers.contact_quadrature import (
    NearSurface,
    measure,
    reached_areas,
    shares_of,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import Value, unchecked
from warp_softbody.world.ground import Ground
from warp_softbody.world.view import BodyView

FORCE_ANGLES = np.pi + 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
"""Of the sliding that each direction of the force opposes, rad from tangent 1."""

TINY = np.finfo(float).tiny


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Patch(Value):
    """One contact of the control problem.

    Attributes:
        weights: (n,), nodal weights of its point, sum one.
        gap: m, its signed distance from the ground.
        frame: (3, 3), rows normal, tangent 1, tangent 2.
        friction: Coulomb coefficient.
        touching: whether any node of it touched in the last step.
        area: its share of what all patches have near the ground; nan where nobody has measured it.
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


class Group(NamedTuple):
    """What of the surface makes a patch: its nodes, their shares (k,), sum one, and its gap, m."""

    near: NearSurface
    shares: FloatArray
    gap: float


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
    return patches_of(view, ground, [measure(view, ground, own) for own in nodes])


def patches_of(view: BodyView, ground: Ground, parts: Sequence[NearSurface]) -> tuple[Patch, ...]:
    """One patch for each part of the surface."""
    if not parts:
        return ()
    groups = [Group(near, *shares_of(view, near)) for near in _divided(parts, view.node_count)]
    frames = _frames(view, groups)
    factors = _force_factors(view, groups, frames)
    lowest = min(near.gaps.min() for near in parts)
    areas = [float(reached_areas(view, near, lowest).sum()) for near in parts]
    return tuple(
        _patch(view, ground, group, frame, own, area / sum(areas))
        for group, frame, own, area in zip(groups, frames, factors, areas, strict=True)
    )


def _divided(parts: Sequence[NearSurface], count: int) -> list[NearSurface]:
    """Parts that have nodes in common share what these bore by their areas around them."""
    areas = np.zeros(count)
    for near in parts:
        areas[near.nodes] += near.areas
    return [
        near._replace(borne=near.borne * near.areas / np.maximum(areas[near.nodes], TINY))
        for near in parts
    ]


def _patch(
    view: BodyView,
    ground: Ground,
    group: Group,
    frame: FloatArray,
    factors: FloatArray,
    area: float,
) -> Patch:
    nodes = group.near.nodes
    weights = np.zeros(view.node_count)
    weights[nodes] = group.shares
    patch = unchecked(
        Patch,
        weights=weights,
        gap=group.gap,
        frame=frame,
        friction=ground.friction,
        touching=bool(view.touching[nodes].any()),
        factors=factors,
        area=area,
        part=None,
        slips=False,
    )
    # a ground that is not ours, or a body far away
    odd = not (math.isfinite(patch.gap) and 0.0 <= patch.friction < math.inf)
    return replace(patch) if odd else patch


def _frames(view: BodyView, groups: Sequence[Group]) -> list[FloatArray]:
    axes, speed = carried_axes(view), SLIDING * BodyUnits.of(view).speed
    return [
        moving_frame(
            _mean_direction(group), group.shares @ view.velocities[group.near.nodes], axes, speed
        )
        for group in groups
    ]


def _mean_direction(group: Group) -> tuple[float, float, float]:
    """Unit mean of the normals; the first itself where all are the same, to the last bit."""
    vectors = group.near.normals
    mean = vectors[0]
    if (vectors != mean).any():
        mean = group.shares @ vectors
        mean = mean / np.linalg.norm(mean)
    x, y, z = mean.tolist()
    return x, y, z


def _force_factors(
    view: BodyView, groups: Sequence[Group], frames: Sequence[FloatArray]
) -> list[FloatArray]:
    """Factors of each patch by the direction of the force, which opposes the sliding."""
    character = view.scene.character
    if not character.directional_friction:
        return [np.ones(DIRECTIONS) for _ in groups]
    by_node = character.node_friction
    nodes = np.concatenate([group.near.nodes for group in groups])
    counts = np.array([len(group.shares) for group in groups])
    begins = np.cumsum(counts) - counts
    carried = (_carrier(character.mesh, by_node.forward.tobytes()) @ view.positions)[nodes]
    tangents = np.repeat([frame[1:] for frame in frames], counts, axis=0)
    ahead = (tangents @ carried[:, :, None])[:, :, 0]
    forward = np.arctan2(ahead[:, 1], ahead[:, 0])
    factors = factors_at(by_node.factors[nodes], FORCE_ANGLES - forward[:, None])
    shares = np.concatenate([group.shares for group in groups])
    return list(np.add.reduceat(factors * shares[:, None], begins))


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
