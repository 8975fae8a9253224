"""What changes from step to step, and belongs to the caller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_softbody.model import Model
from warp_softbody.surface_edges import SurfaceEdges

SLACK = 1e6
"""Rest length, in units of l_0, that no segment reaches: no tension."""


@dataclass(frozen=True)
class State:
    """Where the nodes are and how they move, device arrays.

    Attributes:
        positions: (n,) vec3 m.
        velocities: (n,) vec3 m/s.
        increments: (n,) vec3 m/s, what the last step added to the velocities: where the next
            step's solve starts from, and what it takes its time error from.
    """

    positions: Any
    velocities: Any
    increments: Any

    @staticmethod
    def at_rest(model: Model) -> State:
        """The rest shape, moving with the scene's initial velocity."""
        scene, points = model.scene, model.body.mesh.points
        velocity = np.zeros(points.shape)
        starts = (scene.initial_velocity, *(body.velocity for body in scene.others))
        for part, start in zip(scene.parts, starts, strict=True):
            velocity[part.nodes] = start
        velocity[model.body.fixed] = 0.0
        return State(
            model.array(points, model.types.vec3),
            model.array(velocity, model.types.vec3),
            model.zeros(model.node_count, model.types.vec3),
        )


@dataclass(frozen=True)
class Control:
    """What acts on the body in a step.

    Attributes:
        rest_lengths: (segments,) l_d, m; SLACK * l_0 for a slack segment.
        external_forces: (n,) vec3 N.
    """

    rest_lengths: Any
    external_forces: Any

    @staticmethod
    def slack(model: Model) -> Control:
        """No tension and no push."""
        return Control(
            model.array(SLACK * model.muscles.rest_lengths, model.types.scalar),
            model.zeros(model.node_count, model.types.vec3),
        )


@dataclass(frozen=True)
class PairStates:
    """Contact of surfaces with other bodies' or their own, kept likewise.

    The first pairs are those of the surface nodes with triangles, in their order; two for each edge
    of the surfaces follow, with edges of other bodies, where there are several bodies.

    Attributes:
        modes: (c,) int, as those of `Contacts`.
        impulses: (c,) vec3 N s, onto the node or edge; the other side bears the opposite.
        nodes: (c,) vec4i, of the step: a node and a triangle, or two ends of an edge and of
            another; -1 where there is no pair.
        weights: (c,) vec4, of the nodes on one side adding up to 1, on the other to -1.
        friction_forces, slip_velocities, slip_stiffness: as those of `Contacts`, by pair, of the
            velocity relative to the other side.
    """

    modes: Any
    impulses: Any
    nodes: Any
    weights: Any
    friction_forces: Any
    slip_velocities: Any
    slip_stiffness: Any

    @staticmethod
    def count(model: Model) -> int:
        """How many pairs there may be."""
        mesh = model.body.mesh
        edges = SurfaceEdges.count(mesh.surface) if model.scene.others else 0
        return len(mesh.surface_nodes) + 2 * edges

    @staticmethod
    def none(model: Model) -> PairStates:
        """Nothing touches yet."""
        count, types = PairStates.count(model), model.types
        return PairStates(
            model.zeros(count, int),
            model.zeros(count, types.vec3),
            model.array(np.full((count, 4), -1, dtype=np.int32), wp.vec4i),
            model.zeros(count, types.vec4),
            model.zeros(count, types.vec3),
            model.zeros(count, types.vec3),
            model.zeros(count, types.mat33),
        )


@dataclass(frozen=True)
class Contacts:
    """Contact of the surface nodes, kept from step to step as the next step's first guess.

    Attributes:
        modes: (c,) int, 0 lift, 1 stick, 2 slide.
        impulses: (c,) vec3 N s, from the ground onto the body.
        friction_forces: (n,) vec3 N s, constant part of the linearised friction of sliding nodes.
        slip_velocities: (n,) vec3 m/s, where it was linearised.
        slip_stiffness: (n,) mat33 kg, its derivative by the velocity.
        pairs: contact of surfaces with each other; None where the scene has none.
    """

    modes: Any
    impulses: Any
    friction_forces: Any
    slip_velocities: Any
    slip_stiffness: Any
    pairs: PairStates | None = None

    @staticmethod
    def none(model: Model) -> Contacts:
        """Nothing touches yet."""
        return Contacts(
            model.zeros(model.contact_count, int),
            model.zeros(model.contact_count, model.types.vec3),
            model.zeros(model.node_count, model.types.vec3),
            model.zeros(model.node_count, model.types.vec3),
            model.zeros(model.node_count, model.types.mat33),
            PairStates.none(model) if model.scene.has_pairs else None,
        )
