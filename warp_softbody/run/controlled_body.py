"""A body with a controller: what it sees, what it wants, and the muscles that are its own."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.control_solver import ControlSolver, Decision
from warp_softbody.controllers.controller import Controller, Goals
from warp_softbody.controllers.inner_controllers import says, two_with_one, with_inner
from warp_softbody.controllers.motions.motion_span import MotionSpan, course_of
from warp_softbody.engine.part_rows import part_named
from warp_softbody.engine.reduced_dynamics import ReducedDynamics
from warp_softbody.errors import InputError
from warp_softbody.inputs import input_kinds
from warp_softbody.inputs.records import unchecked, unchecked_copy
from warp_softbody.run.lookahead import Lookahead, steps_ahead
from warp_softbody.run.saved_control import SavedControl, memory_of, remind
from warp_softbody.world.scene import Scene
from warp_softbody.world.view import BodyView


class ControlledBody:
    """Asks one controller in every step; each body of a scene may have one.

    With a name the controller sees its body as if it were alone on the ground: its nodes, its
    regions and its muscles, numbered from 0. What other bodies do to it, it does not know.

    Attributes:
        segments: of all muscles, those that it decides on.
        name: of the body.
    """

    def __init__(
        self,
        lookahead: Lookahead,
        controller: Controller,
        options: ControlOptions,
        name: str | None = None,
    ) -> None:
        """Control the body of a name; None for the character, beside which none is controlled."""
        model = lookahead.stepper(1).model
        scene = model.scene
        self._part = None if name is None else part_named(scene, name)
        self.name = scene.parts[0].name if name is None else name
        self.segments = slice(None) if self._part is None else self._part.segments
        self._alone = None if name is None else _alone(scene, name)
        self._workroom: dict[Any, Any] | None = {} if model.options.native_code else None
        own = scene if self._alone is None else self._alone
        single = any(says(own, "plans_single_steps") for own in with_inner(controller))
        horizon = 0.0 if single else options.horizon
        self._ahead = steps_ahead(horizon, own, model.options.time_step)
        dynamics = ReducedDynamics(
            lookahead.stepper(self._ahead),
            tolerance=options.response_tolerance,
            max_iterations=options.max_response_iterations,
            body=name,
        )
        masses = model.masses
        self._masses = masses if self._part is None else masses[self._part.nodes]
        self._controller = controller
        self._dynamics = dynamics
        self._solver = ControlSolver(controller, dynamics, options)

    @property
    def keeps_upright(self) -> bool:
        """Whether its controller says that it is to keep the body upright now."""
        return says(self._controller, "keeps_upright")

    @property
    def course(self) -> tuple[MotionSpan, ...]:
        """The motions of its controller so far, where that takes several in sequence."""
        return course_of(self._controller)

    def view(self, whole: BodyView) -> BodyView:
        """What the controller sees of a view of all bodies."""
        part = self._part
        if part is None:
            return whole if self._ahead == 1 else unchecked_copy(whole, steps_ahead=self._ahead)
        return unchecked(
            BodyView,
            scene=self._alone,
            time=whole.time,
            time_step=whole.time_step,
            masses=self._masses,
            positions=np.ascontiguousarray(whole.positions[part.nodes]),
            velocities=np.ascontiguousarray(whole.velocities[part.nodes]),
            touching=whole.touching[part.nodes].copy(),
            activations=whole.activations[part.segments].copy(),
            impulses=np.ascontiguousarray(whole.impulses[part.nodes]),
            steps_ahead=self._ahead,
            workroom=self._workroom,
        )

    def goals(self, view: BodyView) -> Goals | None:
        """What the controller wants of the step from its own view on."""
        return self._solver.goals(view)

    def decide(self, view: BodyView, goals: Goals) -> Decision:
        """Rest lengths of its own segments; the step's matrix has to be assembled."""
        return self._solver.decide(view, goals)

    def save(self) -> SavedControl:
        """What controller and solver remember.

        Raises:
            InputError: what the controller remembers cannot be copied.
        """
        return SavedControl(
            name=self.name,
            kind=type(self._controller),
            ahead=self._ahead,
            memory=memory_of(self._controller),
            solver=self._solver.memory,
            responses=self._dynamics.save(),
        )

    def require_fit(self, saved: SavedControl) -> None:
        """Refuse what another body, class of controllers or horizon of plans remembers.

        Raises:
            InputError: it is one.
        """
        kind = type(self._controller)
        if saved.name != self.name or saved.kind is not kind:
            raise InputError(
                f"a SavedMotion with a {saved.kind.__name__} for {saved.name!r} cannot be restored "
                f"by a simulation with a {kind.__name__} for {self.name!r}"
            )
        if saved.ahead != self._ahead:
            raise InputError(
                f"a SavedMotion whose plans look {saved.ahead} time steps ahead cannot be restored "
                f"by a simulation whose plans look {self._ahead} ahead; take the same "
                "ControlOptions.horizon"
            )

    def restore(self, saved: SavedControl) -> None:
        """Remember what a body of the same name, with a controller of the same class, once did."""
        remind(self._controller, saved.memory)
        self._solver.memory = saved.solver
        self._dynamics.restore(saved.responses)


def seen_part(scene: Scene, view: BodyView) -> tuple[slice, slice]:
    """Nodes and segments, of all in a scene, that a controller saw in its view."""
    if view.node_count == sum(len(each.mesh.points) for each in scene.characters):
        return slice(None), slice(None)
    part = part_named(scene, view.scene.character.name)
    return part.nodes, part.segments


def _alone(scene: Scene, name: str) -> Scene:
    """One body of a scene on its ground."""
    character = next(each for each in scene.characters if each.name == name)
    return Scene(character=character, ground=scene.ground, gravity=scene.gravity)


def controlled_bodies(
    lookahead: Lookahead,
    options: ControlOptions,
    controller: Controller | None,
    others: Mapping[str, Controller],
    label: str,
) -> tuple[ControlledBody, ...]:
    """The bodies with controllers, the character first; a warning tells of those without muscles.

    Args:
        lookahead: of all bodies.
        options: of the control solvers.
        controller: of the scene's character.
        others: of other bodies, by their names.
        label: what a warning calls a scene without muscles.

    Raises:
        InputError: there is no such body, or no such controller.
    """
    model = lookahead.stepper(1).model
    scene = model.scene
    own = scene.character.name if others else None
    asked = [] if controller is None else [(own, controller)]
    for name, other in others.items():
        input_kinds.controller(f"controller of {name!r} in others of a Simulation", other)
        if part_named(scene, name) is scene.parts[0]:
            raise InputError(
                f"others of a Simulation names {name!r}, the scene's character, whose controller "
                "is given by itself"
            )
        asked.append((name, other))
    if two_with_one([each] for _, each in asked):
        raise InputError(
            "two bodies of a Simulation have one controller, which remembers its steps; "
            "make one for each"
        )
    found = []
    for body, wanted in asked:
        segments = slice(0, model.segment_count)
        if body is not None:
            segments = part_named(scene, body).segments
        if segments.start < segments.stop:
            found.append(ControlledBody(lookahead, wanted, options, body))
            continue
        warnings.warn(
            f"{body or label!r} has no muscles, so its controller is never asked",
            # the caller of the decorated constructor
            stacklevel=4,
        )
    return tuple(found)
