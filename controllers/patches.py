"""Contact patches: the few points through which a controller thinks of the ground.

The simulator resolves every touching node; the controller sees, for each named region, one point
with the mean velocity of what is near the ground, each node by its share of area and of load
(`contact_quadrature`), in a frame along the motion (`contact_frames`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.directional_friction import DIRECTIONS, factors_at
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.carried_directions import carrier_of
from warp_softbody.controllers.compiled.contact_patches import PatchNumbers
from warp_softbody.controllers.contact_frames import SLIDING, carried_axes, moving_frames
from warp_softbody.controllers.contact_quadrature import NearSurface, measure, shares_of
from warp_softbody.controllers.native_patches import native_patches, nodes_of
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import Value, unchecked
from warp_softbody.world.friction_map import map_of
from warp_softbody.world.ground import Ground
from warp_softbody.world.view import BodyView

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


def ground_patches(view: BodyView, regions: tuple[str, ...]) -> tuple[Patch, ...]:
    """One patch for each named region of the character; none where the scene has no ground."""
    checks.instance("view of ground_patches", view, BodyView)
    regions = input_kinds.names("regions of ground_patches", regions)
    ground = view.scene.ground
    if ground is None or not regions:
        return ()
    if view.workroom is None or len(view.impulses) != view.node_count:
        return patches_of(view, ground, measure(view, ground, nodes_of(view, regions)))
    return _made(view, ground, native_patches(view, ground, regions))


def patches_of(view: BodyView, ground: Ground, near: NearSurface) -> tuple[Patch, ...]:
    """One patch for each part of the surface."""
    shares = shares_of(view, near)
    frames = _frames(view, near, shares.nodes)
    weights = np.zeros((len(near.begins), view.node_count))
    weights[near.parts, near.nodes] = shares.nodes
    touching = np.logical_or.reduceat(view.touching[near.nodes], near.begins)
    factors = _force_factors(view, near, shares.nodes, frames)
    found = (weights, shares.gaps, shares.areas, frames, factors, touching.tolist())
    return _made(view, ground, PatchNumbers(*found))


def _made(view: BodyView, ground: Ground, found: PatchNumbers) -> tuple[Patch, ...]:
    """Patches with these numbers."""
    weights, frames, factors = found.weights, found.frames, found.factors
    frictions = _frictions(view, ground, weights)
    touching, gaps, areas = found.touching, found.gaps.tolist(), found.areas.tolist()
    made = [
        unchecked(
            Patch,
            weights=weights[i],
            gap=gaps[i],
            frame=frames[i],
            friction=frictions[i],
            touching=bool(touching[i]),
            factors=factors[i],
            area=areas[i],
            part=None,
            slips=False,
        )
        for i in range(len(gaps))
    ]
    # a ground that is not ours, or a body far away
    odd = not (all(map(math.isfinite, gaps)) and 0.0 <= ground.friction < math.inf)
    return tuple(replace(patch) for patch in made) if odd else tuple(made)


def _frictions(view: BodyView, ground: Ground, weights: FloatArray) -> list[float]:
    """Coefficients (p,) of patches by their nodal weights (p, n)."""
    placed = map_of(ground)
    if placed is None:
        return [ground.friction] * len(weights)
    means: list[float] = (ground.friction * (weights @ placed.at(view.positions))).tolist()
    return means


def _frames(view: BodyView, near: NearSurface, shares: FloatArray) -> FloatArray:
    """Frames (p, 3, 3) of the patches, rows normal and tangents."""
    slips = near.sums(shares[:, None] * view.velocities[near.nodes])
    normals = _mean_directions(near, shares)
    return moving_frames(normals, slips, carried_axes(view), SLIDING * BodyUnits.of(view).speed)


def _mean_directions(near: NearSurface, shares: FloatArray) -> FloatArray:
    """Unit means (p, 3) of the normals; the first where all are the same, to the last bit."""
    firsts = near.normals[near.begins]
    if (near.normals == firsts[0]).all():
        return firsts
    means = near.sums(shares[:, None] * near.normals)
    return np.asarray(means / np.linalg.norm(means, axis=1, keepdims=True))


def _force_factors(
    view: BodyView, near: NearSurface, shares: FloatArray, frames: FloatArray
) -> FloatArray:
    """Factors (p, 8) of the patches by the direction of the force, which opposes the sliding."""
    character = view.scene.character
    if not character.directional_friction:
        return np.ones((len(frames), DIRECTIONS))
    by_node, nodes = character.node_friction, near.nodes
    carrier = carrier_of(character.mesh, by_node.forward.tobytes())
    carried = (carrier @ view.positions[: carrier.shape[1]])[nodes]
    ahead = (near.of_nodes(frames[:, 1:]) @ carried[:, :, None])[:, :, 0]
    forward = np.arctan2(ahead[:, 1], ahead[:, 0])
    factors = factors_at(by_node.factors[nodes], FORCE_ANGLES - forward[:, None])
    return near.sums(factors * shares[:, None])
