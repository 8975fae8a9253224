"""The constant device arrays of a model, by concern.

Every array has one line with its shape, its element type and its unit. The counts are: n nodes, m
tets, e edges, c surface nodes, s muscle segments, p vertices of fibres, q pairs of a tet and a
segment.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import inverse_edges
from warp_softbody.device.allocator import Allocator, DeviceArray
from warp_softbody.engine.ground_arrays import GroundArrays
from warp_softbody.engine.material_parts import MaterialPart
from warp_softbody.engine.muscle_layout import MuscleLayout
from warp_softbody.linear.block_sparsity import Topology
from warp_softbody.linear.system import MassArrays, PatternArrays
from warp_softbody.world.scene import Scene


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MeshArrays:
    """The meshes of all bodies at rest.

    Attributes:
        tets: (m,) vec4i, corners.
        rest_inverse: (m,) mat33, 1/m, of the edges from corner 0 as columns.
        rest_volume: (m,) scalar, m^3.
        elastic_volume: (m,) scalar, m^3, times the stiffness of each tet over its body's.
        surface_nodes: (c,) int32, nodes of the surface, rising.
    """

    tets: DeviceArray
    rest_inverse: DeviceArray
    rest_volume: DeviceArray
    elastic_volume: DeviceArray
    surface_nodes: DeviceArray

    @staticmethod
    def of(mesh: TetMesh, make: Allocator) -> MeshArrays:
        """A mesh on the device, all of it as stiff as its body's material."""
        inverse = inverse_edges(mesh.points, mesh.tets)
        volumes = make.array(mesh.volumes, make.types.scalar)
        return MeshArrays(
            tets=make.indices(mesh.tets, wp.vec4i),
            rest_inverse=make.array(inverse, make.types.mat33),
            rest_volume=volumes,
            elastic_volume=volumes,
            surface_nodes=make.array(mesh.surface_nodes, wp.int32),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class GatherArrays:
    """Which tets the sums over each edge and each node run over; slot 4 t + a is corner a of tet t.

    Attributes:
        edge_start: (e + 1,) int32, first entry of each edge in ``edge_corners``, and the end.
        edge_corners: (6 m,) vec2i, slots at the lower and the higher node of an edge in a tet.
        edge_slots: (e,) vec2i, places in the matrix of an edge's block and of its transpose.
        tet_edges: (m, 6) int32, edges of each tet.
        node_start: (n + 1,) int32, first entry of each node in ``node_corners``, and the end.
        node_corners: (4 m,) int32, slots of the tets around a node.
    """

    edge_start: DeviceArray
    edge_corners: DeviceArray
    edge_slots: DeviceArray
    tet_edges: DeviceArray
    node_start: DeviceArray
    node_corners: DeviceArray

    @staticmethod
    def of(topology: Topology, make: Allocator) -> GatherArrays:
        """The gather lists of a mesh on the device."""
        return GatherArrays(
            edge_start=make.indices(topology.edge_start),
            edge_corners=make.indices(topology.edge_corners, wp.vec2i),
            edge_slots=make.indices(topology.edge_slots, wp.vec2i),
            tet_edges=make.indices(topology.tet_edges),
            node_start=make.indices(topology.node_start),
            node_corners=make.indices(topology.node_corners),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class StepArrays:
    """What a time step is made with.

    Attributes:
        gravity: (1,) vec3, m/s^2.
        factors: (3,) scalar, dt, s, dt lambda + dt^2, s^2, and 1 + dt mu, of the first body.
        stiffness_share: (n,) scalar, part of K in M~ that is dt^2 K; the rest is damping.
        body_start: (bodies + 1,) int32, first node of each body, and the end.
    """

    gravity: DeviceArray
    factors: DeviceArray
    stiffness_share: DeviceArray
    body_start: DeviceArray

    @staticmethod
    def of(
        scene: Scene, materials: tuple[MaterialPart, ...], dt: float, make: Allocator
    ) -> StepArrays:
        """For a scene and a time step, s."""
        share = np.zeros(len(scene.whole.mesh.points))
        for part in materials:
            share[part.nodes] = dt * dt / part.stiffness_factor
        return StepArrays(
            gravity=make.array([scene.gravity], make.types.vec3),
            factors=materials[0].step_factors,
            stiffness_share=make.array(share, make.types.scalar),
            body_start=make.array([0, *(part.nodes.stop for part in scene.parts)], wp.int32),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MuscleArrays:
    """Muscle segments of all bodies; every array is empty where there are none.

    Attributes:
        point_nodes: (p,) vec4i, corners of the tet around each vertex of a fibre.
        point_weights: (p,) vec4, its barycentric weights there.
        segment_points: (s,) vec2i, vertices at the ends of each segment.
        directions: (s,) vec3, unit, at rest.
        stiffness: (s,) scalar, S / l_0, Pa/m.
        pair_start: (m + 1,) int32, first pair of each tet, and the end.
        pair_segment: (q,) int32, segments of the pairs by tet.
        pair_weight: (q,) scalar, weights of the pairs by tet.
        segment_start: (s + 1,) int32, first pair of each segment, and the end.
        segment_tet: (q,) int32, tets of the pairs by segment.
        segment_weight: (q,) scalar, weights of the pairs by segment.
    """

    point_nodes: DeviceArray
    point_weights: DeviceArray
    segment_points: DeviceArray
    directions: DeviceArray
    stiffness: DeviceArray
    pair_start: DeviceArray
    pair_segment: DeviceArray
    pair_weight: DeviceArray
    segment_start: DeviceArray
    segment_tet: DeviceArray
    segment_weight: DeviceArray

    @staticmethod
    def of(layout: MuscleLayout, tet_count: int, make: Allocator) -> MuscleArrays:
        """The muscles of a layout on the device."""
        types, segments = make.types, len(layout.rest_lengths)
        by_segment = np.argsort(layout.pair_segment, kind="stable")
        segment_start = np.searchsorted(layout.pair_segment[by_segment], np.arange(segments + 1))
        return MuscleArrays(
            point_nodes=make.indices(layout.point_nodes, wp.vec4i),
            point_weights=make.array(layout.point_weights, types.vec4),
            segment_points=make.indices(layout.segment_points, wp.vec2i),
            directions=make.array(layout.directions, types.vec3),
            stiffness=make.array(layout.stiffness, types.scalar),
            pair_start=make.array(layout.by_tet(tet_count), wp.int32),
            pair_segment=make.indices(layout.pair_segment),
            pair_weight=make.array(layout.pair_weight, types.scalar),
            segment_start=make.array(segment_start.astype(np.int32), wp.int32),
            segment_tet=make.array(layout.pair_tet[by_segment], wp.int32),
            segment_weight=make.array(layout.pair_weight[by_segment], types.scalar),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ModelArrays:
    """All constant device arrays of a model; ``ground`` is None where there is no ground."""

    mesh: MeshArrays
    gather: GatherArrays
    pattern: PatternArrays
    masses: MassArrays
    step: StepArrays
    muscles: MuscleArrays
    ground: GroundArrays | None

    @staticmethod
    def of(
        scene: Scene,
        topology: Topology,
        layout: MuscleLayout,
        masses: FloatArray,
        materials: tuple[MaterialPart, ...],
        dt: float,
        make: Allocator,
        *,
        like: ModelArrays | None = None,
        fibers: MuscleArrays | None = None,
    ) -> ModelArrays:
        """Everything constant that kernels read, for nodes of masses (n,) kg and a step dt, s.

        Arrays of meshes are those of ``like``, of the same meshes in the same precision; those of
        muscles, but for their stiffness, those of the same ``fibers``.
        """
        mesh = like.mesh if like else MeshArrays.of(scene.whole.mesh, make)
        if scene.has_region_materials:
            volumes = make.array(scene.elastic_volumes, make.types.scalar)
            mesh = replace(mesh, elastic_volume=volumes)
        elif mesh.elastic_volume is not mesh.rest_volume:
            mesh = replace(mesh, elastic_volume=mesh.rest_volume)
        if fibers is None:
            muscles = MuscleArrays.of(layout, len(scene.whole.mesh.tets), make)
        else:
            muscles = replace(fibers, stiffness=make.array(layout.stiffness, make.types.scalar))
        return ModelArrays(
            mesh=mesh,
            gather=like.gather if like else GatherArrays.of(topology, make),
            pattern=like.pattern if like else PatternArrays.of(topology, make),
            masses=_mass_arrays(scene, masses, materials, make),
            step=StepArrays.of(scene, materials, dt, make),
            muscles=muscles,
            ground=GroundArrays.of(scene, dt, masses, materials, mesh.surface_nodes, make),
        )


def _mass_arrays(
    scene: Scene, masses: FloatArray, materials: tuple[MaterialPart, ...], make: Allocator
) -> MassArrays:
    fixed = np.zeros(len(masses), dtype=np.int32)
    fixed[scene.held] = 1
    damped = masses.copy()
    for part in materials:
        damped[part.nodes] *= part.mass_factor
    return MassArrays(
        mass=make.array(masses, make.types.scalar),
        damped_mass=make.array(damped, make.types.scalar),
        fixed=make.array(fixed, wp.int32),
    )
