"""Steps of bodies in flight that turn: taken along an arc, in a frame that turns with each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp

from warp_softbody.device.host_view import HostView
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.model import Model
from warp_softbody.engine.newton_control import Iterate, NewtonControl
from warp_softbody.engine.state import Contacts, State
from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.flight.arcs import make_arcs
from warp_softbody.kernels.flight.frames import make_frames
from warp_softbody.kernels.flight.groups import PLANNED_SHARE, make_flight_groups
from warp_softbody.kernels.flight.structs import make_flight_structs
from warp_softbody.linear.block_ldlt import Freedom
from warp_softbody.linear.pcg import ConjugateGradients
from warp_softbody.linear.preconditioner import Preconditioner


@dataclass(frozen=True, eq=False)
class Flown:
    """What a step on a straight path leaves behind.

    Attributes:
        right: (n,) vec3 N s, known impulses, without contact, at the step's start.
        outer_impulses: (n,) vec3 N s, of the forces from outside, without gravity.
        change: (n,) vec3 m/s, what the step adds to the velocities.
        found: numbers of the pairs that there are, and how many; None where there are none.
        groups: (bodies,) int, under which bodies had their momenta balanced.
        relinearise: launches the matrix and ``right`` at other positions, for the next iterate of
            velocities ``before + change``; called with (positions, before, change). None where
            nothing turns yet.
    """

    right: Any
    outer_impulses: Any
    change: Any
    found: list[Any] | None
    groups: Any
    relinearise: Callable[[Any, Any, Any], None] | None


class Turning:
    """Replaces the straight path of bodies that turn fast, and that nothing touches, by an arc.

    What touches what is known at the end of a step alone, so that its last solve is repeated for
    such bodies in their frames, with all other bodies held; where there are none, a sum over the
    nodes of each body that nothing touches is all that it costs (docs/method.md section 1).

    Attributes:
        any: (1,) int, whether a body turns in the step.
    """

    def __init__(
        self,
        model: Model,
        solver: ConjugateGradients,
        preconditioner: Preconditioner,
        newton: NewtonControl | None = None,
    ) -> None:
        """Work arrays for the bodies of a model; ``newton`` where a step has iterations."""
        n, vec3 = model.node_count, model.types.vec3
        bodies = len(model.scene.parts)
        self._model = model
        self._solver = solver
        self._preconditioner = preconditioner
        self._newton = newton
        precision = model.options.precision
        self._structs = make_flight_structs(precision)
        self._choice = make_flight_groups(precision)
        factors = np.array([part.stiffness_factor for part in model.materials])
        self._stiffness_factors = model.array(factors, wp.float64)
        groups = np.arange(bodies, dtype=np.int32)
        self._groups = model.array(groups, wp.int32)
        self._turning, self._loose = (model.zeros(bodies, wp.int32) for _ in range(2))
        self._shares = model.zeros(bodies, wp.float64)
        self._bodies = struct_of(
            self._structs.FlightBodies,
            model.arrays.masses,
            node_start=model.arrays.step.body_start,
            gravity=model.arrays.step.gravity,
            step_factors=model.arrays.step.factors,
        )
        vectors = ("centers", "drifts", "momenta", "torques")
        self._spins = struct_of(
            self._structs.Spins,
            inertias=model.zeros(bodies, wp.mat33d),
            **{name: model.zeros(bodies, wp.vec3d) for name in vectors},
        )
        frame = {name: model.zeros(bodies, wp.vec3d) for name in self._structs.Frames.vars}
        self._rigid_frames = struct_of(self._structs.Frames, **frame)
        self.any = model.zeros(1, wp.int32)
        self._read_any = HostView(self.any).read
        self._planned = False
        self._counted = model.array([1.0], wp.float64)
        self._write_counted = HostView(self._counted).write
        # without pairs there are none, which kernels see
        self._pushes = model.zeros(n, vec3) if model.has_pairs else None
        self._kinds = model.zeros(n, wp.int32)
        self._loads, self._loaded = model.zeros(n, vec3), model.zeros(n, vec3)
        again = n if model.options.newton_iterations > 1 else 0
        self._placed, self._still = model.zeros(again, vec3), model.zeros(again, vec3)

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        launch(kernel, dim, inputs, outputs, device)

    def follow_plan(self, planned: bool) -> None:
        """Note whether the steps to come are planned; not to be captured."""
        if planned != self._planned:
            self._planned = planned
            self._write_counted(np.array([PLANNED_SHARE if planned else 1.0]))

    @property
    def found(self) -> bool:
        """Whether a body turns in the step whose choice was made last."""
        return bool(self._read_any()[0])

    def launch_choice(self, state: State, contacts: Contacts, flown: Flown) -> None:
        """Launch which bodies turn, and ``any``, whether there is one, when contact has settled."""
        self._find(self._start_of(state, flown), contacts, flown)

    def launch(self, state: State, contacts: Contacts, after: State, flown: Flown) -> None:
        """Launch the arcs of the bodies that turn, whose straight paths stand in ``after``."""
        self._turn(state, self._start_of(state, flown), contacts, after, flown)

    @cached_property
    def _frames(self) -> Any:
        return self._kernels_of_arcs[0]

    @cached_property
    def _arcs(self) -> Any:
        return self._kernels_of_arcs[1]

    @cached_property
    def _kernels_of_arcs(self) -> tuple[Any, Any]:
        """All of one module: made before any of them is launched, and by runs that turn alone."""
        precision = self._model.options.precision
        return make_frames(precision), make_arcs(precision)

    def _start_of(self, state: State, flown: Flown) -> Any:
        """The struct of the nodes at the start of a step, and of the impulses on them."""
        return struct_of(
            self._structs.StepStart,
            state,
            outer_impulses=flown.outer_impulses,
            pushes=self._pushes,
        )

    def _find(self, start: Any, contacts: Contacts, flown: Flown) -> None:
        """Launch which bodies turn."""
        a, k, bodies = self._model.arrays, self._choice, len(self._shares)
        if flown.found is not None and contacts.pairs is not None:
            pairs, inputs = contacts.pairs, [a.step.body_start, *flown.found, contacts.pairs.nodes]
            joined = [*inputs, pairs.impulses, flown.groups]
            self._launch(k.join_pushed, 1, joined, [self._groups])
            inputs += [pairs.weights, pairs.impulses]
            self._launch(k.spread_impulses, bodies, inputs, [self._pushes])
        inputs = [self._bodies, self._stiffness_factors, self._counted, self._solver.kinds, start]
        self._launch(k.find_spins, bodies, inputs, [self._loose, self._shares, self._spins])
        inputs = [self._groups, self._loose, self._shares]
        self._launch(k.choose_bodies, 1, inputs, [self._turning, self.any, self._solver.counters])

    def _enter(self, start: Any, flown: Flown) -> None:
        """Launch the way into the frames: velocities in them, and their loads."""
        k, solver, frames = self._frames, self._solver, self._rigid_frames
        inputs = [self._bodies, self._turning, self._spins]
        self._launch(k.find_frames, len(self._shares), [*inputs, start], [frames])
        outputs = [solver.kinds, solver.before, solver.start, flown.change, self._loads]
        self._launch(k.enter_frames, self._model.node_count, [*inputs, frames, start], outputs)

    def _turn(
        self, state: State, start: Any, contacts: Contacts, after: State, flown: Flown
    ) -> None:
        """Launch the solve in the frames, and the way out of them."""
        solver = self._solver
        before, change = solver.before, flown.change
        wp.copy(self._kinds, solver.kinds)
        self._enter(start, flown)
        if self._newton is not None and flown.relinearise is not None:
            flown.relinearise(state.positions, self._still, self._still)
        self._load(flown)
        self._solve(contacts, flown)
        if self._newton is not None:
            self._newton.launch(self._iterate(state, contacts, flown))
        inputs = [self._bodies, self._turning, self._groups, self._shares]
        inputs += [self._spins, self._rigid_frames, start, state.carry]
        outputs = [before, change, struct_of(self._structs.StepEnd, after), after.carry]
        self._launch(self._arcs.leave_frames, len(self._shares), inputs, outputs)
        wp.copy(solver.kinds, self._kinds)

    def _iterate(self, state: State, contacts: Contacts, flown: Flown) -> Iterate:
        """Newton's method in the frames, where all that does not turn is held."""
        m, before, change = self._model, self._solver.before, flown.change
        VelocityUpdate = make_contact_structs(m.options.precision).VelocityUpdate

        def linearise() -> None:
            inputs = [m.arrays.step.factors, state.positions, before, change]
            self._launch(self._frames.place, m.node_count, inputs, [self._placed])
            if flown.relinearise is not None:
                flown.relinearise(self._placed, before, change)
            self._load(flown)

        return Iterate(
            change=change,
            moved=struct_of(VelocityUpdate, before=before, change=change),
            right=self._loaded,
            held=self._solver.kinds,
            placed=self._placed,
            linearise=linearise,
            solve=lambda: self._solve(contacts, flown),
        )

    def _load(self, flown: Flown) -> None:
        """Launch the known impulses in the frames."""
        inputs = [flown.right, self._loads]
        self._launch(self._frames.add_loads, self._model.node_count, inputs, [self._loaded])

    def _solve(self, contacts: Contacts, flown: Flown) -> None:
        """Launch one solve for the velocities in the frames."""
        solver = self._solver
        solver.set_target(self._loaded)
        self._preconditioner.prepare(Freedom(solver.kinds, solver.axes, contacts.slip_stiffness))
        solver.solve(self._loaded, contacts.slip_stiffness, flown.change, first=True)
