"""One linearly implicit step (paper eq. 8-9) with contact, captured once as graphs and replayed.

``M~ v+ = M v + dt (f_x + f_e + A (l_d - l)) + contact impulses``, ``x+ = x + dt v+``, with
``M~ = (1 + dt mu) M + (dt lambda + dt^2) K`` and K the warped stiffness; implicit muscles add dt^2
times their own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any, Literal, get_args

import numpy as np
import warp as wp

from warp_softbody.body.mesh_geometry import shortest_edge
from warp_softbody.device.host_view import HostView, HostViews
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.warp_runtime import captured, prepare_captures
from warp_softbody.device.workspace import Workspace
from warp_softbody.engine.assembly import Assembly
from warp_softbody.engine.contact_solver import ContactSolver
from warp_softbody.engine.model import Model
from warp_softbody.engine.momentum_account import Account
from warp_softbody.engine.parallel import Workers
from warp_softbody.engine.state import Contacts, Control, State, check_tensions, checked_parts
from warp_softbody.engine.step_statistics import StepClock, StepStatistics
from warp_softbody.inputs import checks
from warp_softbody.kernels.contact.step_ends import make_step_ends
from warp_softbody.kernels.muscles import make_muscles
from warp_softbody.linear.renewal import Renewal

Part = Literal["assembly", "solve", "contact"]
PARTS: tuple[Part, ...] = get_args(Part)
"""What a step launches, in this order; the control decides between the first and the second."""

WHOLE: tuple[tuple[Part, ...], ...] = (PARTS,)
SINGLE: tuple[tuple[Part, ...], ...] = tuple((part,) for part in PARTS)
"""The parts that make a graph each: all of them together, or one by one."""


def _mark(clock: StepClock | None, part: str) -> None:
    if clock is not None:
        clock.mark(part)


class Stepper:
    """Steps a model; owns work arrays and graphs, never the state.

    Attributes:
        model: what is stepped.
        workspace: of what it works in.
        assembly: rotations, forces and matrix of the state last assembled.
        contact: solves, contact modes and impulses of the last step.
        fiber_points: (p,) vec3 m, vertices of the fibres.
        lengths: (s,) scalar m, of the segments; of implicit ones l_0 times their mean stretch.
        reaches: (s,) scalar m, the most that a segment can be let out to in a step.
        muscle_forces: (4m,) vec3 N, of the last solve, slot 4 t + a at corner a of tet t.
        assembled: the state that was last assembled.
        handled: (n,) vec3 m/s, velocities that handles give in the step that was last begun; None
            without handles.
        holding: how often the nodes that are held have become others.
    """

    @shares_warp
    def __init__(self, model: Model, *, workspace: Workspace | None = None) -> None:
        """Allocate the work arrays of a model.

        Args:
            model: what is stepped.
            workspace: of work arrays that steppers share which never step at the same time; None
                for one of its own.
        """
        checks.instance("model of a Stepper", model, Model)
        self.workspace = checks.optional("workspace of a Stepper", workspace, Workspace)
        work = self.workspace.part("stepper", model.allocator)
        types, m = model.types, model.tet_count
        self.model = model
        self._device = model.options.device
        self._muscles = make_muscles(model.options.precision) if model.segment_count else None
        self._ends = make_step_ends(model.options.precision)
        self.assembly = Assembly(model, self.workspace)
        self.muscle_forces = work.zeros(4 * m if model.segment_count else 1, types.vec3)
        self.fiber_points = model.zeros(len(model.muscles.point_nodes), types.vec3)
        muscles = self.assembly.muscles
        self.lengths = model.zeros(model.segment_count, types.scalar)
        if muscles is not None:
            self.lengths = muscles.lengths
            self._iterate = model.zeros(model.node_count, types.vec3)
        self.reaches = self.lengths if muscles is None else muscles.reaches
        self._tensions = model.zeros(model.segment_count, types.scalar)
        self._extremes = model.zeros(2, wp.float64)
        self._read_extremes = HostView(self._extremes).read
        self._views = HostViews()
        mesh = model.body.mesh
        rounding = float(np.finfo(model.options.precision).eps)
        self._most_reach = shortest_edge(mesh.points, mesh.tets) / rounding
        self.contact = ContactSolver(model, self.assembly, self.workspace)
        self._renewal = Renewal(self.contact.preconditioner, model.system)
        # most runs never turn: on a processor, where asking costs nothing, the kernels of arcs are
        # compiled when a body first does
        self._turns_apart = wp.get_device(self._device).is_cpu
        self.assembled: State | None = None
        self.handled: Any = None
        self.holding = 0
        self._graphs: dict[tuple[Any, ...], Any] = {}
        self._phase_graphs: dict[int, Any] = {}
        self._exchange: tuple[State, State, Any] | None = None
        threads = model.options.threads
        self._workers = Workers(threads, self._device) if threads > 1 else None
        if model.held_count:
            # another stepper of the model may have let go of them
            self.take_held(Control.slack(model))

    @shares_warp
    def prepare(self, state: State, control: Control, contacts: Contacts, after: State) -> None:
        """Begin to compile what steps launch, where kernels have to be compiled at all.

        A loop of one's own need not ask for it: it saves time before the first step, while other
        things are made ready.
        """
        own = (state, control, contacts, after)
        prepare_captures(self._device, lambda: self._launch_parts(PARTS, *own))

    @shares_warp
    def assemble(self, state: State) -> None:
        """Rotations, elastic forces, matrix, muscle lengths and the known momentum of a state.

        Of implicit muscles the matrix knows all, as those that act are not chosen yet.
        """
        self._begin(state)
        self._run_assembly(state)

    def _run_assembly(self, state: State) -> None:
        if self._workers is not None:
            self._assemble_side_by_side(self._workers, state)
        else:
            self._replay(("assembly",), (state,), lambda: self._launch_assembly(state))

    def _assemble_side_by_side(self, workers: Workers, state: State) -> None:
        if id(state) not in self._phase_graphs:
            phases = self.assembly.phases(state.positions, state.velocities)
            # the state is kept alive, so that its identity is not used again
            self._phase_graphs[id(state)] = (workers.capture(phases), state)
        workers.replay(self._phase_graphs[id(state)][0])
        self._replay(("muscles",), (state,), lambda: self._launch_muscle_lengths(state))

    @shares_warp
    def step(
        self,
        state: State,
        control: Control,
        contacts: Contacts,
        after: State,
        *,
        decide: Callable[[], object] | None = None,
        clock: StepClock | None = None,
    ) -> StepStatistics:
        """Advance ``state`` by one time step into ``after``; ``contacts`` are updated in place.

        It is `advance`, and then `conclude`.

        Args:
            state: where the step begins.
            control: what acts in it.
            contacts: of the step before, and after it of this one.
            after: where it ends.
            decide: called once the matrix of ``state`` is assembled, to set ``control``.
            clock: takes the times of the parts.
        """
        self.advance(state, control, contacts, after, decide=decide, clock=clock)
        return self.conclude()

    @shares_warp
    def advance(
        self,
        state: State,
        control: Control,
        contacts: Contacts,
        after: State,
        *,
        decide: Callable[[], object] | None = None,
        clock: StepClock | None = None,
    ) -> None:
        """Take the step that `step` takes; what it took is told by `conclude`.

        The order of a step is here alone: assembly, control, solve, contact. On one thread a step
        that nobody decides in and nobody times is one graph, else each part is one.

        Args:
            state: where the step begins.
            control: what acts in it.
            contacts: of the step before, and after it of this one.
            after: where it ends.
            decide: called once the matrix of ``state`` is assembled, to set ``control``.
            clock: takes the times of the parts.
        """
        if decide is not None:
            checks.called_with("decide of Stepper.step", decide, 0, "a function without arguments")
        if clock is not None:
            checks.instance("clock of Stepper.step", clock, StepClock)
        self.handled = getattr(control, "handled", None)
        self.take_held(control)
        whole = decide is None and clock is None and self._workers is None
        for parts in WHOLE if whole else SINGLE:
            if "assembly" in parts:
                self._begin(state, control if decide is None else None)
            if "solve" in parts:
                if decide is not None:
                    decide()
                    _mark(clock, "control")
                self._prepare(state, control, contacts)
            self._run(parts, state, control, contacts, after)
            _mark(clock, parts[-1])

    @shares_warp
    def take_held(self, control: Control, *, renew: bool = True) -> None:
        """Hold the nodes that a control holds, in all that follows.

        What the preconditioners keep is of other nodes then, and is made anew unless ``renew`` says
        that it has been put in its place.
        """
        if not self.model.held_count:
            return
        checked_parts(self.model, (control,))
        held, fixed = self._views.read(control.held), self.model.arrays.masses.fixed
        if np.array_equal(held, self._views.read(fixed)):
            return
        self._views.write(fixed, held)
        self.contact.let_go(renew=renew)
        self.holding += 1

    def _begin(self, state: State, control: Control | None = None) -> None:
        """Note what is to be assembled, and that no controller has planned the step yet.

        ``control`` is None where it is still to be chosen.
        """
        self.assembled = state
        muscles = self.assembly.muscles
        if muscles is None:
            return
        if control is None:
            muscles.limits.zero_()
        else:
            checked_parts(self.model, (control,))
            wp.copy(muscles.limits, control.rest_lengths)
        self.contact.turning.follow_plan(False)

    def _prepare(self, state: State, control: Control, contacts: Contacts) -> None:
        """Do on the host what precedes the solve, and no graph can hold."""
        if self._muscles is not None and isinstance(control, Control):
            check_tensions(self._views.read(control.rest_lengths))
        self._renewal.choose()
        self.contact.find_pairs(state, contacts, self.handled)

    def _run(
        self,
        parts: tuple[Part, ...],
        state: State,
        control: Control,
        contacts: Contacts,
        after: State,
    ) -> None:
        """Replay parts of a step that follow each other, as one graph."""
        if parts == ("assembly",):
            self._run_assembly(state)
            return

        own = (state, control, contacts, after)
        ends = own if "contact" in parts else own[:-1]
        self._replay(parts, ends, lambda: self._launch_parts(parts, *own))
        if "solve" in parts:
            self._renewal.done()
        if "contact" in parts and self._turns_apart and self.contact.turning.found:
            self._replay(("turning",), own, lambda: self._launch_turning(*own))

    def _launch_parts(
        self,
        parts: tuple[Part, ...],
        state: State,
        control: Control,
        contacts: Contacts,
        after: State,
    ) -> None:
        launches: dict[Part, Callable[[], None]] = {
            "assembly": lambda: self._launch_assembly(state),
            "solve": lambda: self._launch_solve(state, control, contacts),
            "contact": lambda: self._launch_contact(state, control, contacts, after),
        }
        for part in parts:
            launches[part]()

    @shares_warp
    def exchange(self, state: State, after: State) -> None:
        """Let two states of the model exchange what they hold.

        A loop that goes from one state to the other and back needs two graphs of a step. One that
        lets them exchange, and steps from the same one each time, needs one, which saves a capture
        (10 ms) and its memory.
        """
        known = self._exchange
        # asked for in every step, and mostly of the same two
        if known is None or known[0] is not state or known[1] is not after:
            own = (state, after)
            checked_parts(self.model, own)
            graph = captured(self._device, lambda: self._launch_exchange(own))
            known = self._exchange = (state, after, graph)
        wp.capture_launch(known[2])

    def _launch_exchange(self, own: tuple[State, State]) -> None:
        both = [getattr(state, entry.name) for state in own for entry in fields(State)]
        self._launch(self._ends.exchange_states, self.model.node_count, [], both)

    def account(self) -> Account:
        """What all steps so far did to the bodies' momentum, and contact to their energy."""
        return self.contact.accountant.read()

    def follow_plan(self) -> None:
        """Note that the step from the assembled state is planned by its linear maps."""
        self.contact.turning.follow_plan(True)

    def _replay(
        self, name: tuple[str, ...], own: tuple[object, ...], launch: Callable[[], None]
    ) -> None:
        """Replay a graph; the first time, capture it. States are told apart by identity."""
        identity = (*name, *map(id, own))
        if identity not in self._graphs:
            checked_parts(self.model, own)
            # the states are kept alive, so that their identities are not used again
            self._graphs[identity] = (captured(self._device, launch), own)
        wp.capture_launch(self._graphs[identity][0])

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, dim, inputs, outputs, self._device)

    def _launch_assembly(self, state: State) -> None:
        self.assembly.launch(state.positions, state.velocities)
        self._launch_muscle_lengths(state)

    def _launch_muscle_lengths(self, state: State) -> None:
        m, a = self.model, self.model.arrays
        if self._muscles is not None:
            points = [a.muscles.point_nodes, a.muscles.point_weights, state.positions]
            count = len(m.muscles.point_nodes)
            self._launch(self._muscles.fiber_points, count, points, [self.fiber_points])
            if self.assembly.muscles is None:
                ends = [a.muscles.segment_points, self.fiber_points]
                self._launch(self._muscles.segment_lengths, m.segment_count, ends, [self.lengths])

    def _known_forces(self, control: Control) -> Any:
        """The struct of what a step is driven by, beside contact."""
        return struct_of(
            self._ends.KnownForces,
            self.model.arrays.gather,
            impulses=self.assembly.impulses,
            external=control.external_forces,
            muscles=self.muscle_forces,
            has_muscles=int(self._muscles is not None),
        )

    def _launch_solve(self, state: State, control: Control, contacts: Contacts) -> None:
        m, a, k, contact = self.model, self.model.arrays, self._ends, self.contact
        self._launch_muscle_forces(control)
        if m.scene.handles:
            wp.copy(contact.handled, control.handled)
        inputs = [a.step.factors, int(m.options.follows_time_error), self._known_forces(control)]
        inputs += [state.velocities, state.increments, contacts.friction_forces]
        outputs = [contact.sides, contact.velocity_update, contact.start]
        self._launch(k.right_side, m.node_count, inputs, outputs)
        contact.launch_first(state, contacts, self._renewal)

    def _launch_muscle_forces(self, control: Control, *, again: bool = False) -> None:
        """Tensions from the lengths last found, and their forces by corner."""
        m, a = self.model, self.model.arrays.muscles
        if self._muscles is None:
            return
        implicit, limits = self.assembly.muscles, control.rest_lengths
        if implicit is not None and not again:
            implicit.launch_tensions(limits, self._tensions)
        else:
            inputs = [a.stiffness, limits, self.lengths]
            self._launch(self._muscles.segment_tensions, m.segment_count, inputs, [self._tensions])
        if implicit is not None:
            implicit.launch_forces(self._tensions, self.muscle_forces, again=again)
            return
        pairs = [a.pair_start, a.pair_segment, a.pair_weight, a.directions]
        inputs = [*pairs, self._tensions, self.assembly.rotations, self.assembly.area_rows]
        self._launch(self._muscles.muscle_tets, m.tet_count, inputs, [self.muscle_forces])

    def _launch_contact(
        self, state: State, control: Control, contacts: Contacts, after: State
    ) -> None:
        m, k = self.model, self._ends
        ends = [after.positions, after.velocities, after.increments, after.carry]
        before = [state.positions, state.velocities]
        inputs = [m.arrays.step.factors, *before, self.contact.change, self.contact.carry]
        self.contact.launch_modes(state, contacts)
        moved = self.contact.velocity_update

        def linearise() -> None:
            self._launch(k.advance_state, m.node_count, inputs, ends)
            self._launch_again(state, control, contacts, after.positions, moved)

        if m.options.newton_iterations > 1:
            self.contact.launch_newton(state, contacts, after.positions, linearise)
        self._launch(k.advance_state, m.node_count, inputs, ends)
        self.contact.launch_choice_of_turning(state, contacts)
        own = (state, control, contacts, after)
        wp.capture_if(
            self.contact.turning.any,
            on_true=None if self._turns_apart else lambda: self._launch_turning(*own),
            on_false=lambda: self._launch_measures(contacts, after),
        )

    def _launch_turning(
        self, state: State, control: Control, contacts: Contacts, after: State
    ) -> None:
        """Launch the arcs of bodies in flight that turn, and what ends such a step."""

        def relinearise(positions: Any, before: Any, change: Any) -> None:
            moved = struct_of(self._ends.VelocityUpdate, before=before, change=change)
            self._launch_again(state, control, contacts, positions, moved)

        self.contact.launch_turning(state, contacts, after, relinearise)
        self._launch_measures(contacts, after)

    def _launch_measures(self, contacts: Contacts, after: State) -> None:
        """Launch what is measured of a step that is over."""
        ends = [after.positions, after.velocities]
        self._launch(self._ends.find_extremes, 1, ends, [self._extremes])
        self.contact.launch_account(contacts)

    def _launch_again(
        self, state: State, control: Control, contacts: Contacts, positions: Any, moved: Any
    ) -> None:
        """Matrix and known impulses of one more Newton iteration about ``positions``.

        ``moved`` is the struct of the velocities before the step and their change so far.
        """
        m, a, k, contact = self.model, self.model.arrays, self._ends, self.contact
        iterate, muscles = None, self.assembly.muscles
        if muscles is not None:
            iterate = self._iterate
            self._launch(k.add_up, m.node_count, [moved.before, moved.change], [iterate])
            wp.copy(muscles.limits, control.rest_lengths)
        self.assembly.launch(positions, state.velocities, iterate)
        if muscles is not None:
            self._launch_muscle_forces(control, again=True)
        inputs = [a.step.factors, a.step.stiffness_share, a.pattern.row_start, a.pattern.column]
        inputs += [self.assembly.values, self._known_forces(control), moved]
        inputs += [contacts.friction_forces]
        self._launch(k.newton_right_side, m.node_count, inputs, [contact.sides])

    @shares_warp
    def conclude(self) -> StepStatistics:
        """What the last step took; to be called once after every `advance`.

        The choice of the next step's preconditioner comes from it.
        """
        reach, speed = self._read_extremes().tolist()
        resolved = reach < self._most_reach
        renewed = self._renewal.due
        return self.contact.read_statistics(renewed=renewed, resolved=resolved, fastest=speed)
