"""What changes from step to step, and belongs to the caller."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.body.surface_edges import SurfaceEdges
from warp_softbody.device.turns import shares_warp
from warp_softbody.engine.model import Model
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

SLACK = 1e6
"""Rest length, in units of l_0, that no segment reaches: no tension."""


OPTIONAL = ("pairs", "handled", "held")
"""Fields that are None in scenes without what they are of."""


def _check_arrays(part: object) -> None:
    """Refuse fields that are no arrays of a device."""
    for entry in fields(part):  # type: ignore[arg-type]
        value = getattr(part, entry.name)
        if entry.name in OPTIONAL and value is None:
            continue
        if not isinstance(value, PairStates if entry.name == "pairs" else wp.array):
            checks.refuse(f"{type(part).__name__}.{entry.name}", "a Warp array of a device", value)


@dataclass(frozen=True, eq=False, repr=False)
class State:
    """Where the nodes are and how they move, device arrays.

    Attributes:
        positions: (n,) vec3 m.
        velocities: (n,) vec3 m/s.
        increments: (n,) vec3 m/s, what the last step added to the velocities: where the next
            step's solve starts from, and what it takes its time error from.
        carry: (2 bodies,) vec3d, momentum, N s, and angular momentum about the centre of mass,
            N m s, that rounding has kept the velocities of each body from taking.
    """

    positions: Any
    velocities: Any
    increments: Any
    carry: Any

    def __post_init__(self) -> None:
        """Refuse what is not on a device."""
        _check_arrays(self)

    @staticmethod
    @shares_warp
    def at_rest(model: Model) -> State:
        """The scene's start: bodies in their poses, with their velocities, and as handles move."""
        checks.instance("model of State.at_rest", model, Model)
        scene, points = model.scene, model.scene.start_points
        velocity = np.zeros(points.shape)
        for part, (start, spin) in zip(scene.parts, scene.starts, strict=True):
            velocity[part.nodes] = start
            if any(spin):
                masses, places = model.masses[part.nodes], points[part.nodes]
                arms = places - masses @ places / masses.sum()
                velocity[part.nodes] += np.cross(spin, arms)
        velocity[model.body.fixed] = 0.0
        dt = model.options.time_step
        for handle, nodes in zip(scene.handles, scene.handle_nodes, strict=True):
            rest = model.body.mesh.points[nodes]
            points[nodes] = handle.path.places(rest, 0.0)
            velocity[nodes] = (handle.path.places(rest, dt) - points[nodes]) / dt
        return State(
            model.array(points, model.types.vec3),
            model.array(velocity, model.types.vec3),
            model.zeros(model.node_count, model.types.vec3),
            model.zeros(2 * len(scene.parts), wp.vec3d),
        )


@dataclass(frozen=True, eq=False, repr=False)
class Control:
    """What acts on the body in a step.

    Attributes:
        rest_lengths: (segments,) l_d, m; SLACK * l_0 for a slack segment.
        external_forces: (n,) vec3 N.
        handled: (n,) vec3 m/s, velocities of the nodes that handles move; None where the scene
            has no handles.
        held: (n,) int, 1 where a node is fixed or moved by a handle in the step, else 0; None where
            no handle of the scene lets go.
    """

    rest_lengths: Any
    external_forces: Any
    handled: Any = None
    held: Any = None

    def __post_init__(self) -> None:
        """Refuse what is not on a device."""
        _check_arrays(self)

    @staticmethod
    @shares_warp
    def slack(model: Model) -> Control:
        """No tension and no push."""
        checks.instance("model of Control.slack", model, Model)
        held = np.zeros(model.held_count, np.int32)
        if len(held):
            held[model.scene.held] = 1
        return Control(
            model.array(SLACK * model.muscles.rest_lengths, model.types.scalar),
            model.zeros(model.node_count, model.types.vec3),
            model.zeros(model.node_count, model.types.vec3) if model.scene.handles else None,
            model.array(held, wp.int32) if len(held) else None,
        )


@dataclass(frozen=True, eq=False, repr=False)
class PairStates:
    """Contact of surfaces with other bodies' or their own, kept likewise.

    The first pairs are those of the surface nodes with triangles, in their order; two for each edge
    of the surfaces follow, with edges of other bodies, where there are several bodies, and at last
    two for each edge with edges of the ground, where that has sharp ones.

    Attributes:
        modes: (c,) int, as those of `Contacts`.
        impulses: (c,) vec3 N s, onto the node or edge; the other side bears the opposite.
        nodes: (c,) vec4i, of the step: a node and a triangle, or two ends of an edge and of
            another; -1 where there is no pair. With the ground two ends of an edge, twice.
        weights: (c,) vec4, of the nodes on one side adding up to 1, on the other to -1, or all zero
            where that is the ground.
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
        on_ground = PairStates._edges(model.scene.has_ground_edges, model)
        return PairStates.first_on_ground(model) + on_ground

    @staticmethod
    def first_on_ground(model: Model) -> int:
        """The number of the first one that may be with an edge of the ground."""
        scene = model.scene
        nodes = len(model.body.mesh.surface_nodes) if scene.has_pairs else 0
        return nodes + PairStates._edges(len(scene.parts) > 1, model)

    @staticmethod
    def _edges(there: bool, model: Model) -> int:
        """Two for each edge of the surfaces, where there are such pairs."""
        return 2 * SurfaceEdges.count(model.body.mesh.surface) if there else 0

    @staticmethod
    @shares_warp
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


@dataclass(frozen=True, eq=False, repr=False)
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

    def __post_init__(self) -> None:
        """Refuse what is not on a device."""
        _check_arrays(self)

    @staticmethod
    @shares_warp
    def none(model: Model) -> Contacts:
        """Nothing touches yet."""
        checks.instance("model of Contacts.none", model, Model)
        return Contacts(
            model.zeros(model.contact_count, int),
            model.zeros(model.contact_count, model.types.vec3),
            model.zeros(model.node_count, model.types.vec3),
            model.zeros(model.node_count, model.types.vec3),
            model.zeros(model.node_count, model.types.mat33),
            PairStates.none(model) if model.has_pairs else None,
        )


def check_tensions(lengths: npt.NDArray[Any]) -> None:
    """Refuse rest lengths that are not finite: of them no segment would pull, and nothing tell."""
    if not np.isfinite(lengths).all():
        segment = int(np.flatnonzero(~np.isfinite(lengths))[0])
        raise InputError(
            f"Control.rest_lengths must be finite numbers of m, but that of segment {segment} is "
            f"{lengths[segment]}; a slack one has {SLACK:g} times its length at rest"
        )


def checked_parts(model: Model, parts: tuple[object, ...]) -> None:
    """Refuse what a stepper of a model cannot step from or to.

    Raises:
        InputError: something else than a State, Control or Contacts, or one of another model.
    """
    types = model.types
    for part in parts:
        if isinstance(part, State):
            shapes = dict.fromkeys(("positions", "velocities", "increments"), model.node_count)
        elif isinstance(part, Control):
            shapes = {"rest_lengths": model.segment_count, "external_forces": model.node_count}
            if model.scene.handles:
                if part.handled is None:
                    raise InputError("Control.handled must be there: handles move nodes")
                shapes["handled"] = model.node_count
            if model.held_count:
                if part.held is None:
                    raise InputError("Control.held must be there: a handle lets go of nodes")
                shapes["held"] = model.node_count
        elif isinstance(part, Contacts):
            shapes = {"modes": model.contact_count, "friction_forces": model.node_count}
            if model.has_pairs and part.pairs is None:
                raise InputError("Contacts.pairs must be there: surfaces of the scene may touch")
        else:
            checks.refuse("what a Stepper steps", "a State, Control or Contacts", part)
        for name, count in shapes.items():
            array = getattr(part, name)
            if array.shape != (count,) or array.dtype not in (types.vec3, types.scalar, wp.int32):
                raise InputError(
                    f"{type(part).__name__}.{name} must hold {count} values in {types.name} for "
                    f"this model, not {array.shape} of {array.dtype.__name__}"
                )
