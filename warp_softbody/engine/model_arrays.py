"""The constant device arrays of a model, by the name of the kernel argument they are handed to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.engine.muscle_layout import MuscleLayout
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.rest_matrix import rest_gradients
from warp_softbody.kernels.precision import Real
from warp_softbody.linear.aggregation import Aggregation
from warp_softbody.linear.block_ldlt import constant_integers
from warp_softbody.linear.block_sparsity import Topology
from warp_softbody.world.joined_bodies import Part
from warp_softbody.world.scene import Scene

Arrays = dict[str, Any]

SLOWEST_SLIDING = 1e-8
"""Speed, m/s, below which nothing slides, however stiff."""

STILL = 1e-5
"""Speed, m/s, off the ground or along it, that counts as none."""

EARTH = 9.81
"""Gravity, m/s^2, with which a body of a metre moves at the speeds that tolerances are made for."""


def speed_share(scene: Scene) -> float:
    """Speeds of a scene's smallest body, sqrt(g size), of those of a metre on Earth; at most 1."""
    sizes = [np.linalg.norm(np.ptp(c.mesh.points, axis=0)) for c in scene.characters]
    gravity = float(np.linalg.norm(scene.gravity)) or EARTH
    return float(min(1.0, np.sqrt(gravity * min(sizes) / EARTH)))


@dataclass(frozen=True)
class Allocator:
    """Makes device arrays in the types of a precision."""

    types: Real
    device: str

    def array(self, values: npt.ArrayLike, dtype: Any) -> Any:
        """A device array of values."""
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=self.device)

    def indices(self, values: npt.NDArray[np.int32], dtype: Any = wp.int32) -> Any:
        """A device array of constant integers; on the CPU it shares their memory."""
        return constant_integers(values, dtype, self.device)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any) -> Any:
        """A device array of zeros."""
        return wp.zeros(shape, dtype=dtype, device=self.device)


@dataclass(frozen=True, kw_only=True)
class MaterialPart:
    """What the assembly needs of one body.

    Attributes:
        material: of the body.
        nodes, tets, edges: where it stands in the joined arrays.
        stiffness_factor: dt lambda + dt^2, of K in M~.
        mass_factor: 1 + dt mu, of M in M~.
        lame: (2,) mu and lambda, Pa, on the device.
        step_factors: (3,) dt and the two factors, on the device.
    """

    material: Material
    nodes: slice
    tets: slice
    edges: slice
    stiffness_factor: float
    mass_factor: float
    lame: Any
    step_factors: Any


def material_parts(
    parts: tuple[Part, ...], topology: Topology, dt: float, make: Allocator
) -> tuple[MaterialPart, ...]:
    """The materials of all bodies; edges are sorted by their lower node, so by body."""
    low = topology.column[topology.edge_slots[:, 1]]
    scalar = make.types.scalar
    found = []
    for part in parts:
        material = part.material
        first, last = np.searchsorted(low, [part.nodes.start, part.nodes.stop]).tolist()
        stiffness = dt * material.stiffness_damping + dt * dt
        mass = 1.0 + dt * material.mass_damping
        found.append(
            MaterialPart(
                material=material,
                nodes=part.nodes,
                tets=part.tets,
                edges=slice(first, last),
                stiffness_factor=stiffness,
                mass_factor=mass,
                lame=make.array([material.lame_mu, material.lame_lambda], scalar),
                step_factors=make.array([dt, stiffness, mass], scalar),
            )
        )
    return tuple(found)


def device_arrays(
    make: Allocator,
    scene: Scene,
    options: SimulationOptions,
    topology: Topology,
    aggregation: Aggregation | None,
    muscles: MuscleLayout,
    masses: FloatArray,
    materials: tuple[MaterialPart, ...],
) -> Arrays:
    """Everything constant that kernels read."""
    mesh = scene.whole.mesh
    arrays = _body_arrays(make, scene, masses)
    arrays |= _topology_arrays(make, topology)
    arrays |= _damping_arrays(make, masses, materials, options.time_step)
    arrays["tolerance"] = make.array([options.solver_tolerance], wp.float64)
    if aggregation is not None:
        arrays |= _aggregate_arrays(make, aggregation)
    arrays |= _muscle_arrays(make, muscles, len(mesh.tets))
    if scene.ground is not None or scene.has_pairs:
        arrays |= _surface_arrays(make, scene, options.time_step, masses, materials)
    if scene.ground is not None:
        arrays |= _ground_arrays(make, scene, scene.ground.friction)
    return arrays


def _body_arrays(make: Allocator, scene: Scene, masses: FloatArray) -> Arrays:
    types, body = make.types, scene.whole
    fixed = np.zeros(len(masses), dtype=np.int32)
    fixed[body.fixed] = 1
    return {
        "tets": make.indices(body.mesh.tets, wp.vec4i),
        "rest_inverse": make.array(_rest_inverse(body.mesh), types.mat33),
        "rest_volume": make.array(body.mesh.volumes, types.scalar),
        "gravity": make.array([scene.gravity], types.vec3),
        "mass": make.array(masses, types.scalar),
        "fixed": make.array(fixed, wp.int32),
        "body_start": make.array([0, *(part.nodes.stop for part in scene.parts)], wp.int32),
    }


def _damping_arrays(
    make: Allocator, masses: FloatArray, materials: tuple[MaterialPart, ...], dt: float
) -> Arrays:
    """(1 + dt mu) m of each node, and what of K in M~ is dt^2 K; the factors of the first body."""
    damped, share = masses.copy(), np.zeros(len(masses))
    for part in materials:
        damped[part.nodes] *= part.mass_factor
        share[part.nodes] = dt * dt / part.stiffness_factor
    scalar = make.types.scalar
    return {
        "damped_mass": make.array(damped, scalar),
        "stiffness_share": make.array(share, scalar),
        "step_factors": materials[0].step_factors,
    }


def _rest_inverse(mesh: TetMesh) -> FloatArray:
    corners = mesh.points[mesh.tets]
    return np.asarray(np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)))


def _topology_arrays(make: Allocator, topology: Topology) -> Arrays:
    return {
        "row_start": make.indices(topology.row_start),
        "column": make.indices(topology.column),
        "diagonal_slot": make.indices(topology.diagonal_slot),
        "edge_start": make.indices(topology.edge_start),
        "edge_corners": make.indices(topology.edge_corners, wp.vec2i),
        "tet_edges": make.indices(topology.tet_edges),
        "edge_slots": make.indices(topology.edge_slots, wp.vec2i),
        "node_start": make.indices(topology.node_start),
        "node_corners": make.indices(topology.node_corners),
    }


def _aggregate_arrays(make: Allocator, aggregation: Aggregation) -> Arrays:
    return {
        "aggregate_of": make.indices(aggregation.aggregate_of),
        "aggregate_start": make.indices(aggregation.start),
        "aggregate_nodes": make.indices(aggregation.nodes),
        "offsets": make.array(aggregation.offsets, make.types.vec3),
    }


def _muscle_arrays(make: Allocator, layout: MuscleLayout, tet_count: int) -> Arrays:
    types, segments = make.types, len(layout.rest_lengths)
    by_segment = np.argsort(layout.pair_segment, kind="stable")
    segment_start = np.searchsorted(layout.pair_segment[by_segment], np.arange(segments + 1))
    return {
        "point_nodes": make.indices(layout.point_nodes, wp.vec4i),
        "point_weights": make.array(layout.point_weights, types.vec4),
        "segment_points": make.indices(layout.segment_points, wp.vec2i),
        "directions": make.array(layout.directions, types.vec3),
        "muscle_stiffness": make.array(layout.stiffness, types.scalar),
        "pair_start": make.array(layout.by_tet(tet_count), wp.int32),
        "pair_segment": make.indices(layout.pair_segment),
        "pair_weight": make.array(layout.pair_weight, types.scalar),
        "segment_start": make.array(segment_start.astype(np.int32), wp.int32),
        "segment_tet": make.array(layout.pair_tet[by_segment], wp.int32),
        "segment_weight": make.array(layout.pair_weight[by_segment], types.scalar),
    }


def _surface_arrays(
    make: Allocator,
    scene: Scene,
    dt: float,
    masses: FloatArray,
    materials: tuple[MaterialPart, ...],
) -> Arrays:
    """The nodes that may touch, and what counts as zero there."""
    nodes = scene.whole.mesh.surface_nodes
    starts = [0, *(part.nodes.stop for part in scene.parts)]
    # a millionth of the weight's impulse, and 0.01 mm/s off what is touched for bodies of a metre
    weight = float(masses.sum()) * float(np.linalg.norm(scene.gravity))
    impulse = 1e-6 * weight * dt
    # along it, the speed that a node's own block answers with twenty of these impulses: a stiff
    # body's friction changes much while its nodes hardly move
    share = speed_share(scene)
    still = speed = STILL * share
    if weight > 0.0:
        largest = _largest_block(scene.whole.mesh, masses, materials)
        speed = min(speed, max(SLOWEST_SLIDING * share, 20.0 * impulse / largest))
    return {
        "surface_nodes": make.array(nodes, wp.int32),
        "contact_start": make.array(np.searchsorted(nodes, starts).astype(np.int32), wp.int32),
        "contact_tolerances": make.array([impulse, still, 5e-2, speed], make.types.scalar),
    }


def _ground_arrays(make: Allocator, scene: Scene, friction: float) -> Arrays:
    types, body = make.types, scene.whole
    nodes = body.mesh.surface_nodes
    forward, factors = np.zeros((1, 3)), np.zeros((1, 1))
    if body.directional_friction:
        by_node = body.node_friction
        forward, factors = by_node.forward[nodes], by_node.factors[nodes]
    return {
        "friction_coefficient": make.array(np.full(len(nodes), friction), types.scalar),
        "forward": make.array(forward, types.vec3),
        "friction_factors": make.array(factors, types.scalar),
    }


def _largest_block(mesh: TetMesh, masses: FloatArray, materials: tuple[MaterialPart, ...]) -> float:
    """Largest third of the trace of a surface node's block of M~ at rest, kg."""
    squares = (rest_gradients(mesh) ** 2).sum(axis=2)
    blocks = np.zeros(len(masses))
    for part in materials:
        # K_aa = V ((mu |g|^2) I + (mu + lambda) g g^T)
        modulus = 4.0 * part.material.lame_mu + part.material.lame_lambda
        shares = (part.stiffness_factor * modulus / 3.0) * mesh.volumes[part.tets]
        np.add.at(blocks, mesh.tets[part.tets], shares[:, None] * squares[part.tets])
        blocks[part.nodes] += part.mass_factor * masses[part.nodes]
    return float(blocks[mesh.surface_nodes].max())
