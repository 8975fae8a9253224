"""The constant part of a scene's linear systems: the pattern, and which preconditioner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import shortest_edge
from warp_softbody.device.allocator import Allocator
from warp_softbody.engine.material_parts import MaterialPart
from warp_softbody.engine.model_arrays import ModelArrays
from warp_softbody.engine.options import PreconditionerChoice, SimulationOptions
from warp_softbody.engine.precision_choice import hardest_material, stiffness_over_mass
from warp_softbody.engine.rest_matrix import rest_matrix
from warp_softbody.linear.aggregation import Aggregation, build_aggregation, coarse_matrix
from warp_softbody.linear.block_sparsity import Topology
from warp_softbody.linear.symbolic_ldlt import Elimination, build_elimination
from warp_softbody.linear.system import AggregateArrays, CoarseLevel, LinearSystem
from warp_softbody.world.scene import Scene

MOST_FACTOR_BLOCKS, MOST_MUSCLED_BLOCKS = 12_000, 40_000
"""Blocks of a body's factor beyond which two levels cost less than it, by measurement: of a body
that is dropped, and of one with muscles, for whose plan each step is solved for many times."""

LARGEST_FACTOR = 2500
"""Nodes beyond which hardly a factor has so few blocks."""

PIVOT_ROUNDINGS = 200.0
"""Roundings of a pivot that may be added to it."""

LOST_MASS = 100.0
"""One over the part of the mass that rounding of the stiffness takes where all of them are."""

HELD_MARGIN = 0.5
"""Of that, what contact holds and the coarse level lets go; a tenth of its roundings is borne."""

MOST_LOST = 0.5
"""Of that, beyond which the coarse level is not told what contact holds: of a motion that a stiff
body's ground holds, rounding would leave nothing."""


@dataclass(frozen=True, kw_only=True)
class Levels:
    """What is factorised.

    Attributes:
        elimination: of the matrix that is factorised, the coarse one where there are aggregates.
        aggregation: of the nodes of a large body; None for others.
    """

    elimination: Elimination
    aggregation: Aggregation | None


def build_levels(
    scene: Scene, topology: Topology, fixed: npt.NDArray[np.bool_], choice: PreconditionerChoice
) -> Levels:
    """The levels asked for; "auto" takes a whole factor for small bodies, aggregates for large.

    ``fixed`` (n,) bool are the nodes that do not move.
    """
    parts = scene.parts
    largest = max(part.nodes.stop - part.nodes.start for part in parts)
    if choice == "factor" or (choice == "auto" and largest <= LARGEST_FACTOR):
        elimination = build_elimination(topology, fixed)
        muscled = any(character.muscles for character in scene.characters)
        most = MOST_MUSCLED_BLOCKS if muscled else MOST_FACTOR_BLOCKS
        if choice == "factor" or len(elimination.column) <= most * len(parts):
            return Levels(elimination=elimination, aggregation=None)
    aggregation = build_aggregation(topology, fixed, scene.whole.mesh.points)
    none = np.zeros(2 * aggregation.count, dtype=bool)
    elimination = build_elimination(aggregation.pattern, none)
    return Levels(elimination=elimination, aggregation=aggregation)


def build_linear_system(
    scene: Scene,
    options: SimulationOptions,
    topology: Topology,
    levels: Levels,
    masses: FloatArray,
    materials: tuple[MaterialPart, ...],
    arrays: ModelArrays,
    make: Allocator,
) -> LinearSystem:
    """The constant part of the systems of a scene with nodes of masses (n,) kg."""
    coarse = None
    lost = _lost_mass(scene, options)
    if levels.aggregation is not None:
        factors = _rest_factors(topology, masses, materials)
        volumes = scene.elastic_volumes
        values = rest_matrix(scene.whole.mesh, topology, *factors, volumes=volumes)
        coarse = CoarseLevel(
            aggregation=levels.aggregation,
            aggregates=AggregateArrays.of(levels.aggregation, scene.whole.mesh.points, make),
            values=coarse_matrix(levels.aggregation, topology, values),
            held_margin=HELD_MARGIN * lost if scene.ground and lost < MOST_LOST else None,
        )
    return LinearSystem(
        allocator=make,
        node_count=len(masses),
        pattern=arrays.pattern,
        masses=arrays.masses,
        tolerance=make.array([options.solver_tolerance], wp.float64),
        follows_time_error=options.follows_time_error,
        max_iterations=options.max_iterations,
        elimination=levels.elimination,
        pivot_margin=PIVOT_ROUNDINGS * float(np.finfo(options.precision).eps) * lost,
        coarse=coarse,
        native_code=options.native_code,
    )


def _rest_factors(
    topology: Topology, masses: FloatArray, materials: tuple[MaterialPart, ...]
) -> tuple[FloatArray, FloatArray]:
    """Of the matrix M~: (n,) (1 + dt mu) m, and (e, 2) (dt lambda + dt^2) mu and lambda."""
    damped = masses.copy()
    lame = np.zeros((len(topology.edge_slots), 2))
    for part in materials:
        damped[part.nodes] *= part.mass_factor
        material = part.material
        lame[part.edges] = material.lame_mu, material.lame_lambda
        lame[part.edges] *= part.stiffness_factor
    return damped, lame


def _lost_mass(scene: Scene, options: SimulationOptions) -> float:
    """Part of the mass that rounding of the stiffness takes, of all that may be; 1 at most.

    As large a share of `PIVOT_ROUNDINGS` is added to pivots, so that rounding leaves factors
    positive definite: what elimination leaves of a stiff body's mass may be less than rounding
    takes; a soft one needs no margin, and its factor is better without.
    """
    rounding = float(np.finfo(options.precision).eps)
    ratio = max(
        stiffness_over_mass(
            hardest_material(character),
            shortest_edge(character.mesh.points, character.mesh.tets),
            options.time_step,
        )
        for character in scene.characters
    )
    return min(1.0, LOST_MASS * rounding * ratio)
