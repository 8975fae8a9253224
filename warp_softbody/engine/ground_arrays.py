"""The constant device arrays of the surface nodes that may touch the ground, c of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.device.allocator import Allocator, DeviceArray
from warp_softbody.engine.contact_tolerances import ContactTolerances, contact_tolerances
from warp_softbody.engine.material_parts import MaterialPart
from warp_softbody.world.scene import Scene


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class GroundArrays:
    """Surface nodes as they meet the ground.

    Attributes:
        nodes: (c,) int32, nodes that may touch, those of the surface.
        body_start: (bodies + 1,) int32, first entry of each body in ``nodes``, and the end.
        tolerances: what counts as zero.
        friction: (c,) scalar, coefficient of each node, before a map's factor (`PlacedFriction`).
        forward: (c,) vec3, unit, at rest, of friction by direction; one unused entry without it.
        friction_factors: (c, k) scalar, factors of the coefficient by direction; likewise.
    """

    nodes: DeviceArray
    body_start: DeviceArray
    tolerances: ContactTolerances
    friction: DeviceArray
    forward: DeviceArray
    friction_factors: DeviceArray

    @staticmethod
    def of(
        scene: Scene,
        dt: float,
        masses: FloatArray,
        materials: tuple[MaterialPart, ...],
        surface_nodes: DeviceArray,
        make: Allocator,
    ) -> GroundArrays | None:
        """For the ground of a scene; None without one."""
        if scene.ground is None:
            return None
        types, body = make.types, scene.whole
        nodes = body.mesh.surface_nodes
        starts = np.searchsorted(nodes, [0, *(part.nodes.stop for part in scene.parts)])
        forward, factors = np.zeros((1, 3)), np.zeros((1, 1))
        if body.directional_friction:
            by_node = body.node_friction
            forward, factors = by_node.forward[nodes], by_node.factors[nodes]
        return GroundArrays(
            nodes=surface_nodes,
            body_start=make.array(starts.astype(np.int32), wp.int32),
            tolerances=contact_tolerances(scene, dt, masses, materials),
            friction=make.array(np.full(len(nodes), scene.ground.friction), types.scalar),
            forward=make.array(forward, types.vec3),
            friction_factors=make.array(factors, types.scalar),
        )
