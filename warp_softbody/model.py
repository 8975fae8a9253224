"""The constant part of a simulation, on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.aggregation import Aggregation, build_aggregation, coarse_matrix
from warp_softbody.block_factor import constant_integers
from warp_softbody.elimination import Elimination, build_elimination
from warp_softbody.ground_friction import friction_by_node
from warp_softbody.kernels.precision import Real, real
from warp_softbody.muscle_layout import MuscleLayout, build_muscle_layout
from warp_softbody.options import SimulationOptions
from warp_softbody.rest_matrix import rest_matrix
from warp_softbody.scene import Scene
from warp_softbody.topology import Topology, build_topology

FloatArray = npt.NDArray[np.float64]
Arrays = dict[str, Any]

CHUNKS = 64
"""Pieces that sums over nodes are cut into; fixed, so that a sum does not depend on the machine."""


SLOWEST_SLIDING = 1e-8
"""Speed, m/s, below which nothing slides, however stiff."""

LARGEST_FACTOR = 450
"""Nodes beyond which two levels cost less than a factor, by measurement."""


def lumped_masses(
    points: FloatArray, tets: npt.NDArray[np.int32], volumes: FloatArray, density: float
) -> FloatArray:
    """Nodal masses (n,) kg: a quarter of each tet's mass to each corner."""
    masses = np.zeros(len(points))
    np.add.at(masses, tets.ravel(), np.repeat(density * volumes / 4.0, 4))
    return masses


@dataclass(frozen=True, kw_only=True)
class Model:
    """What stays constant, on host and device.

    Attributes:
        scene: what is simulated.
        options: how.
        topology, muscles: index arrays on the host.
        elimination: of the matrix that is factorised, the coarse one where there are aggregates.
        aggregation: of the nodes of a large body; None for others.
        fixed: (n,) bool.
        masses: (n,) kg, float64 on the host.
        types: Warp types of the precision.
        arrays: device arrays by the name of the kernel argument they are handed to.
    """

    scene: Scene
    options: SimulationOptions
    topology: Topology
    elimination: Elimination
    aggregation: Aggregation | None
    fixed: npt.NDArray[np.bool_]
    muscles: MuscleLayout
    masses: FloatArray
    types: Real
    arrays: Arrays

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return len(self.masses)

    @property
    def tet_count(self) -> int:
        """Number of tets."""
        return len(self.scene.character.mesh.tets)

    @property
    def segment_count(self) -> int:
        """Number of muscle segments."""
        return len(self.muscles.rest_lengths)

    @property
    def contact_count(self) -> int:
        """Number of nodes that can touch the ground; 0 without a ground."""
        return 0 if self.scene.ground is None else len(self.scene.character.mesh.surface_nodes)

    @property
    def coarse_values(self) -> FloatArray:
        """The coarse level's matrix at rest, (coarse blocks, 3, 3)."""
        assert self.aggregation is not None
        character, dt = self.scene.character, self.options.time_step
        material = character.material
        mass_factor = 1.0 + dt * material.mass_damping
        factors = (mass_factor, dt * material.stiffness_damping + dt * dt)
        body = (character.mesh, self.topology, material, self.masses)
        return coarse_matrix(self.aggregation, self.topology, rest_matrix(*body, *factors))

    @property
    def chunk(self) -> int:
        """Nodes per chunk of a sum."""
        return -(-self.node_count // CHUNKS)

    @property
    def chunk_count(self) -> int:
        """Number of chunks that hold nodes."""
        return -(-self.node_count // self.chunk)

    def array(self, values: npt.ArrayLike, dtype: Any) -> Any:
        """A device array of values."""
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=self.options.device)

    def indices(self, values: npt.NDArray[np.int32], dtype: Any = wp.int32) -> Any:
        """A device array of constant integers; on the CPU it shares their memory."""
        return constant_integers(values, dtype, self.options.device)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any) -> Any:
        """A device array of zeros."""
        return wp.zeros(shape, dtype=dtype, device=self.options.device)


def build_model(scene: Scene, options: SimulationOptions) -> Model:
    """The model of a scene: index arrays, rest shape, masses, muscle weights, ground."""
    character = scene.character
    mesh = character.mesh
    topology = build_topology(mesh.tets, len(mesh.points))
    fixed = np.zeros(len(mesh.points), dtype=bool)
    fixed[character.fixed] = True
    aggregation = None
    elimination = None
    if len(mesh.points) > LARGEST_FACTOR:
        aggregation = build_aggregation(topology, fixed, mesh.points)
        none = np.zeros(2 * aggregation.count, dtype=bool)
        elimination = build_elimination(aggregation.pattern, none)
    model = Model(
        scene=scene,
        options=options,
        topology=topology,
        elimination=elimination or build_elimination(topology, fixed),
        aggregation=aggregation,
        fixed=fixed,
        muscles=build_muscle_layout(character),
        masses=lumped_masses(mesh.points, mesh.tets, mesh.volumes, character.material.density),
        types=real(options.precision),
        arrays={},
    )
    model.arrays.update(_body_arrays(model))
    model.arrays.update(_aggregate_arrays(model))
    model.arrays.update(_muscle_arrays(model))
    model.arrays.update(_ground_arrays(model))
    return model


def _body_arrays(model: Model) -> Arrays:
    types, topology = model.types, model.topology
    mesh, material = model.scene.character.mesh, model.scene.character.material
    corners = mesh.points[mesh.tets]
    rest_inverse = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    dt = model.options.time_step
    factors = [
        dt,
        dt * material.stiffness_damping + dt * dt,
        1.0 + dt * material.mass_damping,
    ]
    return {
        "tets": model.indices(mesh.tets, wp.vec4i),
        "rest_inverse": model.array(rest_inverse, types.mat33),
        "rest_volume": model.array(mesh.volumes, types.scalar),
        "lame": model.array([material.lame_mu, material.lame_lambda], types.scalar),
        "step_factors": model.array(factors, types.scalar),
        "gravity": model.array([model.scene.gravity], types.vec3),
        "mass": model.array(model.masses, types.scalar),
        "fixed": model.array(model.fixed.astype(np.int32), wp.int32),
        "row_start": model.indices(topology.row_start, wp.int32),
        "column": model.indices(topology.column, wp.int32),
        "diagonal_slot": model.indices(topology.diagonal_slot, wp.int32),
        "edge_start": model.indices(topology.edge_start, wp.int32),
        "edge_corners": model.indices(topology.edge_corners, wp.vec2i),
        "tet_edges": model.indices(topology.tet_edges, wp.int32),
        "edge_slots": model.indices(topology.edge_slots, wp.vec2i),
        "node_start": model.indices(topology.node_start, wp.int32),
        "node_corners": model.indices(topology.node_corners, wp.int32),
        "tolerance": model.array([model.options.solver_tolerance], wp.float64),
    }


def _aggregate_arrays(model: Model) -> Arrays:
    aggregation = model.aggregation
    if aggregation is None:
        return {}
    return {
        "aggregate_of": model.indices(aggregation.aggregate_of, wp.int32),
        "aggregate_start": model.indices(aggregation.start, wp.int32),
        "aggregate_nodes": model.indices(aggregation.nodes, wp.int32),
        "offsets": model.array(aggregation.offsets, model.types.vec3),
    }


def _muscle_arrays(model: Model) -> Arrays:
    types, layout = model.types, model.muscles
    by_segment = np.argsort(layout.pair_segment, kind="stable")
    segment_start = np.searchsorted(
        layout.pair_segment[by_segment], np.arange(model.segment_count + 1)
    )
    return {
        "point_nodes": model.indices(layout.point_nodes, wp.vec4i),
        "point_weights": model.array(layout.point_weights, types.vec4),
        "segment_points": model.indices(layout.segment_points, wp.vec2i),
        "directions": model.array(layout.directions, types.vec3),
        "muscle_stiffness": model.array(layout.stiffness, types.scalar),
        "pair_start": model.array(layout.by_tet(model.tet_count), wp.int32),
        "pair_segment": model.indices(layout.pair_segment, wp.int32),
        "pair_weight": model.array(layout.pair_weight, types.scalar),
        "segment_start": model.array(segment_start.astype(np.int32), wp.int32),
        "segment_tet": model.array(layout.pair_tet[by_segment], wp.int32),
        "segment_weight": model.array(layout.pair_weight[by_segment], types.scalar),
    }


def _ground_arrays(model: Model) -> Arrays:
    ground = model.scene.ground
    if ground is None:
        return {}
    types, character = model.types, model.scene.character
    nodes = character.mesh.surface_nodes
    forward, factors = np.zeros((1, 3)), np.zeros((1, 1))
    if character.directional_friction:
        by_node = friction_by_node(character)
        forward, factors = by_node.forward[nodes], by_node.factors[nodes]
    # what counts as zero: a millionth of the weight's impulse, and 0.01 mm/s off the ground
    weight = float(model.masses.sum()) * float(np.linalg.norm(model.scene.gravity))
    impulse = 1e-6 * weight * model.options.time_step
    # along it, the speed that a node's own block answers with twenty of these impulses: a stiff
    # body's friction changes much while its nodes hardly move
    speed = 1e-5
    if weight > 0.0:
        speed = min(speed, max(SLOWEST_SLIDING, 20.0 * impulse / _largest_block(model)))
    return {
        "surface_nodes": model.array(nodes, wp.int32),
        "friction_coefficient": model.array(np.full(len(nodes), ground.friction), types.scalar),
        "forward": model.array(forward, types.vec3),
        "friction_factors": model.array(factors, types.scalar),
        "contact_tolerances": model.array([impulse, 1e-5, 5e-2, speed], types.scalar),
    }


def _largest_block(model: Model) -> float:
    """Largest third of the trace of a surface node's block of M~ at rest, kg."""
    mesh, material = model.scene.character.mesh, model.scene.character.material
    corners = mesh.points[mesh.tets]
    inner = np.linalg.inv((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))
    gradients = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)
    # K_aa = V ((mu |g|^2) I + (mu + lambda) g g^T)
    traces = (4.0 * material.lame_mu + material.lame_lambda) * (gradients**2).sum(axis=2)
    stiffness = np.zeros(model.node_count)
    np.add.at(stiffness, mesh.tets, mesh.volumes[:, None] * traces / 3.0)
    dt = model.options.time_step
    blocks = (1.0 + dt * material.mass_damping) * model.masses
    blocks += (dt * material.stiffness_damping + dt * dt) * stiffness
    return float(blocks[mesh.surface_nodes].max())
