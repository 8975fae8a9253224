"""The constant part of a simulation, on the device."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.mesh_geometry import shortest_edge
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.warp_runtime import check_device
from warp_softbody.engine.model_arrays import (
    Allocator,
    MaterialPart,
    device_arrays,
    material_parts,
    speed_share,
)
from warp_softbody.engine.muscle_layout import MuscleLayout, build_muscle_layout, join_layouts
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.precision_choice import stiffness_over_mass, with_precision
from warp_softbody.engine.rest_matrix import rest_matrix
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.kernels.precision import Real, real
from warp_softbody.linear.aggregation import Aggregation, build_aggregation, coarse_matrix
from warp_softbody.linear.block_sparsity import Topology, build_topology
from warp_softbody.linear.symbolic_ldlt import Elimination, build_elimination
from warp_softbody.world.scene import Scene

CHUNKS = 64
"""Pieces that sums over nodes are cut into; fixed, so that a sum does not depend on the machine."""


MOST_FACTOR_BLOCKS = 12_000
"""Blocks of a body's factor beyond which two levels cost less than it, by measurement."""

PIVOT_ROUNDINGS = 200.0
"""Roundings of a pivot that may be added to it."""

LOST_MASS = 100.0
"""One over the part of the mass that rounding of the stiffness takes where all of them are."""

RECOVERY_SPEED = 0.5
"""Speed, m/s, at which a sunken node of a body of a metre is pushed out."""

LARGEST_FACTOR = 1000
"""Nodes beyond which no factor has so few blocks."""


def lumped_masses(
    points: FloatArray, tets: npt.NDArray[np.int32], volumes: FloatArray, density: float
) -> FloatArray:
    """Nodal masses (n,) kg: a quarter of each tet's mass to each corner."""
    masses = np.zeros(len(points))
    np.add.at(masses, tets.ravel(), np.repeat(density * volumes / 4.0, 4))
    return masses


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Model:
    """What stays constant, on host and device.

    Attributes:
        scene: what is simulated.
        materials: of each body.
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
    arrays: dict[str, Any]
    materials: tuple[MaterialPart, ...]

    @property
    def body(self) -> Character:
        """All bodies of the scene as one of several parts."""
        return self.scene.whole

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return len(self.masses)

    @property
    def tet_count(self) -> int:
        """Number of tets."""
        return len(self.body.mesh.tets)

    @property
    def segment_count(self) -> int:
        """Number of muscle segments."""
        return len(self.muscles.rest_lengths)

    @property
    def contact_count(self) -> int:
        """Number of nodes that can touch the ground; 0 without a ground."""
        return 0 if self.scene.ground is None else len(self.body.mesh.surface_nodes)

    @property
    def absent_parts(self) -> tuple[str, ...]:
        """Which of "muscles" and "contact" the scene has none of."""
        touchable = self.scene.ground is not None or self.scene.has_pairs
        there = {"muscles": self.segment_count > 0, "contact": touchable}
        return tuple(part for part, is_there in there.items() if not is_there)

    @property
    def coarse_values(self) -> FloatArray:
        """The coarse level's matrix at rest, (coarse blocks, 3, 3)."""
        assert self.aggregation is not None
        values = rest_matrix(self.body.mesh, self.topology, *self._rest_factors)
        return coarse_matrix(self.aggregation, self.topology, values)

    @property
    def _rest_factors(self) -> tuple[FloatArray, FloatArray]:
        """Of the matrix M~: (n,) (1 + dt mu) m, and (e, 2) (dt lambda + dt^2) mu and lambda."""
        masses = self.masses.copy()
        lame = np.zeros((len(self.topology.edge_slots), 2))
        for part in self.materials:
            masses[part.nodes] *= part.mass_factor
            material = part.material
            lame[part.edges] = material.lame_mu, material.lame_lambda
            lame[part.edges] *= part.stiffness_factor
        return masses, lame

    @property
    def speed_share(self) -> float:
        """What speeds count for small bodies, of those that do for a metre on Earth; at most 1."""
        return speed_share(self.scene)

    @property
    def recovery_speed(self) -> float:
        """Largest speed at which a sunken node is pushed out, m/s."""
        asked = self.options.recovery_speed
        return RECOVERY_SPEED * self.speed_share if asked is None else asked

    @cached_property
    def pivot_margin(self) -> float:
        """Part of a pivot that is added to it, so that rounding leaves factors positive definite.

        What elimination leaves of a stiff body's mass may be less than rounding takes; a soft one
        needs no margin, and its factor is better without.
        """
        rounding = float(np.finfo(self.options.precision).eps)
        scene, dt = self.scene, self.options.time_step
        edges = [shortest_edge(c.mesh.points, c.mesh.tets) for c in scene.characters]
        ratio = max(
            stiffness_over_mass(character.material, edge, dt)
            for character, edge in zip(scene.characters, edges, strict=True)
        )
        return PIVOT_ROUNDINGS * rounding * min(1.0, LOST_MASS * rounding * ratio)

    @property
    def chunk(self) -> int:
        """Nodes per chunk of a sum."""
        return -(-self.node_count // CHUNKS)

    @property
    def chunk_count(self) -> int:
        """Number of chunks that hold nodes."""
        return -(-self.node_count // self.chunk)

    @property
    def allocator(self) -> Allocator:
        """Makes device arrays."""
        return Allocator(self.types, self.options.device)

    def array(self, values: npt.ArrayLike, dtype: Any) -> Any:
        """A device array of values."""
        return self.allocator.array(values, dtype)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any) -> Any:
        """A device array of zeros."""
        return self.allocator.zeros(shape, dtype)


@shares_warp
def build_model(scene: Scene, options: SimulationOptions) -> Model:
    """The model of a scene: index arrays, rest shape, masses, muscle weights, ground.

    Raises:
        InputError: options that do not go with the scene, or a device that is not there.
    """
    checks.instance("scene of build_model", scene, Scene)
    checks.instance("options of build_model", options, SimulationOptions)
    check_device(options.device)
    options = with_precision(options, scene)
    body, parts = scene.whole, scene.parts
    _refuse_mixtures(scene, options)
    mesh = body.mesh
    topology = build_topology(mesh.tets, len(mesh.points))
    fixed = np.zeros(len(mesh.points), dtype=bool)
    fixed[body.fixed] = True
    aggregation = None
    elimination = None
    if max(part.nodes.stop - part.nodes.start for part in parts) <= LARGEST_FACTOR:
        elimination = build_elimination(topology, fixed)
    if elimination is None or len(elimination.column) > MOST_FACTOR_BLOCKS * len(parts):
        aggregation = build_aggregation(topology, fixed, mesh.points)
        none = np.zeros(2 * aggregation.count, dtype=bool)
        elimination = build_elimination(aggregation.pattern, none)
    make = Allocator(real(options.precision), options.device)
    layouts = [build_muscle_layout(character) for character in scene.characters]
    muscles = join_layouts(layouts, parts)
    masses = np.concatenate([_masses(character) for character in scene.characters])
    materials = material_parts(parts, topology, options.time_step, make)
    return Model(
        scene=scene,
        options=options,
        topology=topology,
        elimination=elimination,
        aggregation=aggregation,
        fixed=fixed,
        muscles=muscles,
        masses=masses,
        types=make.types,
        materials=materials,
        arrays=device_arrays(
            make, scene, options, topology, aggregation, muscles, masses, materials
        ),
    )


def _refuse_mixtures(scene: Scene, options: SimulationOptions) -> None:
    for character in scene.characters:
        if character.material.volume == "exact" and (
            options.elements != "linear" or options.tangent != "warped"
        ):
            raise InputError(
                f"body {character.name!r} resists its exact change of volume, which linear "
                f"elements with the warped tangent know alone, got {options.elements} elements "
                f"and the {options.tangent} tangent"
            )


def _masses(character: Character) -> FloatArray:
    mesh = character.mesh
    return lumped_masses(mesh.points, mesh.tets, mesh.volumes, character.material.density)
