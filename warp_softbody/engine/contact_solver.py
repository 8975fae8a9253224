"""Contact of a step: solves with given modes, and the choice of modes, until they settle."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import warp as wp

from warp_softbody.device.host_view import HostView
from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.workspace import Workspace
from warp_softbody.engine.assembly import Assembly
from warp_softbody.engine.ground_contact import GroundContact
from warp_softbody.engine.model import Model
from warp_softbody.engine.momentum_account import Accountant
from warp_softbody.engine.newton_control import Iterate, NewtonControl
from warp_softbody.engine.pair_contact import PairConstraints, PairContact, StepVectors
from warp_softbody.engine.rigid_balance import RigidBalance
from warp_softbody.engine.state import Contacts, PairStates, State
from warp_softbody.engine.step_statistics import StepStatistics
from warp_softbody.engine.turning import Flown, Turning
from warp_softbody.inputs.records import unchecked
from warp_softbody.kernels.contact.stages import ALL_PASSES
from warp_softbody.kernels.contact.step_ends import make_step_ends
from warp_softbody.kernels.linear.codes import Counter, Scalar
from warp_softbody.linear.block_ldlt import Freedom
from warp_softbody.linear.pcg import ConjugateGradients
from warp_softbody.linear.preconditioner import make_preconditioner
from warp_softbody.linear.renewal import Renewal

FRESH_ITERATIONS = 3
"""Iterations of one pass that even a fresh factor would need."""


def _may_be_hasty(model: Model) -> bool:
    """Whether modes may be sought by few iterations.

    So they may in large bodies, whose iterations cost most. A kept factor leaves a pass one to
    five. Pairs have few passes, and bodies stacked on each other need good modes from the start.
    """
    large = model.system.coarse is not None
    enough = model.options.max_contact_passes >= ALL_PASSES
    return large and enough and not model.has_pairs


class ContactSolver:
    """Finds the velocities of a step and the contact modes that go with them.

    Attributes:
        right: (n,) vec3 N s, known impulses of the step, without contact.
        right_with_slip: the same with the constant part of friction.
        outer_impulses: (n,) vec3 N s, of the forces from outside, without gravity.
        before: (n,) vec3 m/s, the velocities before the step.
        accountant: keeps the account of all steps.
        start: (n,) vec3 m/s, the change that the step's first solve starts from.
        change: (n,) vec3 m/s, what the step adds to the velocities.
        sides: struct of ``right``, ``right_with_slip`` and ``outer_impulses``.
        velocity_update: struct of ``before`` and ``change``.
        carry: (2 bodies,) vec3d, momenta that rounding keeps velocities from taking.
        preconditioner: of the solves.
        newton: control of the iterations; None where there is one only.
        turning: of bodies in flight.
        fresh: iterations of a pass that even a fresh preconditioner would need.
    """

    def __init__(self, model: Model, assembly: Assembly, workspace: Workspace) -> None:
        """Work arrays for the matrix that ``assembly`` makes."""
        types, n = model.types, model.node_count
        self._model = model
        self._assembly = assembly
        self._ends = make_step_ends(model.options.precision)
        self.right = model.zeros(n, types.vec3)
        self.right_with_slip = model.zeros(n, types.vec3)
        self.outer_impulses = model.zeros(n, types.vec3)
        self.change = model.zeros(n, types.vec3)
        self._velocities = model.zeros(n if model.has_pairs else 0, types.vec3)
        self.preconditioner = make_preconditioner(
            *(model.system, assembly.values, assembly.node_rotations, workspace), serves="vectors"
        )
        self._solver = ConjugateGradients(
            *(model.system, assembly.values, self.preconditioner), hasty=_may_be_hasty(model)
        )
        self.before, self.start = self._solver.before, self._solver.start
        self.sides = struct_of(self._ends.RightSide, self)
        self.velocity_update = struct_of(
            self._ends.VelocityUpdate, before=self.before, change=self.change
        )
        self._balance = RigidBalance(model, self._solver)
        self.carry = self._balance.carry
        self._ground = GroundContact(model, assembly, self._solver)
        self.newton: NewtonControl | None = None
        if model.options.newton_iterations > 1:
            self.newton = NewtonControl(model, assembly.values, self._solver)
        self.turning = Turning(model, self._solver, self.preconditioner, self.newton)
        self._pairs: PairContact | None = None
        self.accountant = Accountant(model)
        self._read_counters = HostView(self._solver.counters).read
        self._read_scalars = HostView(self._solver.scalars).read
        self._renewing = False
        self.fresh = float(FRESH_ITERATIONS)
        if model.has_pairs:
            self._pairs = PairContact(model, self._solver, assembly.values)

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._model.options.device
        launch(kernel, dim, inputs, outputs, device)

    @property
    def kept(self) -> tuple[Any, ...]:
        """Device arrays that the next step begins with, beside state and contacts."""
        return (*self.preconditioner.kept, self._solver.counters)

    @property
    def pairs(self) -> PairContact | None:
        """Contact of surfaces with each other; None where the scene has none."""
        return self._pairs

    @property
    def _found_pairs(self) -> list[Any] | None:
        """Numbers of the pairs that there are, and how many; None without pairs."""
        return None if self._pairs is None else self._pairs.lists

    @property
    def handled(self) -> Any:
        """(n,) vec3 m/s, velocities that handles give in the step; (0,) without handles."""
        return self._ground.handled

    def find_pairs(self, state: State, contacts: Contacts, handled: Any) -> None:
        """Which surfaces may touch in a step from ``state`` on; not to be captured.

        ``handled`` is that of `Control`.
        """
        if self._pairs is not None and contacts.pairs is not None:
            self._pairs.find(state, contacts.pairs, handled)
            self._renewing = self.preconditioner.stale

    def let_go(self, *, renew: bool) -> None:
        """Note that other nodes are held than before; ``renew`` as of `Stepper.take_held`."""
        # steps say which are held, and what contact holds
        self._solver.kinds.zero_()
        if renew:
            self.preconditioner.age = float("inf")

    def launch_first(self, state: State, contacts: Contacts, renewal: Renewal) -> None:
        """Launch the first solve of a step, with the modes of the last one."""
        self._solver.begin_step()
        if self.newton is not None:
            self.newton.launch_reset()
        self._add_pair_frictions(contacts)
        self._solver.set_target(self.right)
        self._ground.detect(state)
        self._launch_pass(state, contacts, renewal=renewal, first=True)

    def launch_newton(
        self,
        state: State,
        contacts: Contacts,
        placed: Any,
        linearise: Callable[[], None],
    ) -> None:
        """Launch the further Newton iterations, once the modes of the first have settled.

        ``linearise`` launches matrix and known impulses about the present velocities, for which
        ``placed`` (n,) vec3 m then has the positions.
        """
        if self.newton is None:
            return

        def solve() -> None:
            self._add_pair_frictions(contacts)
            self._solver.set_target(self.right)
            self._launch(self._ends.begin_iteration, 1, [], [self._solver.counters])
            self._launch_pass(state, contacts)
            self.launch_modes(state, contacts)

        self.newton.launch(
            Iterate(
                change=self.change,
                moved=self.velocity_update,
                right=self.right,
                held=self._model.arrays.masses.fixed,
                placed=placed,
                linearise=linearise,
                solve=solve,
                contacts=contacts,
                found=self._found_pairs,
                carry=self.carry,
            )
        )

    def launch_modes(self, state: State, contacts: Contacts) -> None:
        """Launch the choice of modes, and solves with them, until they settle."""
        if not self._model.contact_count and self._pairs is None:
            return
        self._launch_update(contacts)

        def settle() -> None:
            self._launch_pass(state, contacts)
            self._launch_update(contacts)

        again = Counter.AGAIN
        wp.capture_while(self._solver.counters[again : again + 1], settle)
        if self._pairs is not None:
            wp.capture_if(self._pairs.unsettled, lambda: self._launch_ending(state, contacts))

    def _launch_ending(self, state: State, contacts: Contacts) -> None:
        """Launch the end of a step whose pairs did not settle."""
        if self._pairs is None or contacts.pairs is None:
            return
        frictions, stiffness = contacts.friction_forces, contacts.slip_stiffness
        sides = (self.right, self.right_with_slip, frictions, stiffness)
        moved = (self.before, self.change, self._velocities)
        known = StepVectors(*sides, *moved, self._add_up, self._take_difference)

        def solve(pairs: PairStates | None) -> None:
            self._launch_pass(state, replace(contacts, pairs=pairs))

        self._pairs.end_safely(contacts.pairs, solve, self._solver, known)

    def _add_pair_frictions(self, contacts: Contacts) -> None:
        if self._pairs is not None and contacts.pairs is not None:
            known = [self.right, contacts.friction_forces, self.right_with_slip]
            self._pairs.add_frictions(contacts.pairs, *known)

    def _launch_pass(
        self,
        state: State,
        contacts: Contacts,
        *,
        renewal: Renewal | None = None,
        first: bool = False,
    ) -> None:
        """Launch a solve with the modes as they are, and what follows from it for bodies."""
        self._ground.impose(contacts, self.change)
        freedom = Freedom(self._solver.kinds, self._solver.axes, contacts.slip_stiffness)
        if renewal is not None:
            renewal.launch(freedom)
        self.preconditioner.prepare(freedom)
        rows = None
        if self._pairs is not None and contacts.pairs is not None:
            self._add_up()
            self._pairs.impose(contacts.pairs, self._velocities)
            self._take_difference()
            rows = PairConstraints(self._pairs, contacts.pairs, self._velocities)
        slip_stiffness = contacts.slip_stiffness
        known = (self.right_with_slip, slip_stiffness, self.change)
        self._solver.solve(*known, rows, first=first)

        def go_on() -> None:
            # an old factor may serve so badly that a new one is cheaper than its iterations
            self.preconditioner.renew(freedom)
            self.preconditioner.prepare(freedom)
            self._solver.solve(*known, rows, again=True)

        wp.capture_if(self._solver.failed, go_on)
        found = self._found_pairs
        self._balance.launch(state, contacts, found, self.outer_impulses, self.change)

    def _add_up(self) -> None:
        """Launch the velocities at the step's end, which pairs work on."""
        inputs = [self.before, self.change]
        self._launch(self._ends.add_up, self._model.node_count, inputs, [self._velocities])

    def _take_difference(self) -> None:
        """Launch the change that leads to the velocities, where pairs have changed them."""
        inputs = [self.before, self._velocities]
        self._launch(self._ends.take_difference, self._model.node_count, inputs, [self.change])

    def _launch_update(self, contacts: Contacts) -> None:
        """Launch the impulses of the last solve, and the modes of the next one."""
        solver = self._solver
        right, pairs = self.right, contacts.pairs
        if self._pairs is not None and pairs is not None:
            self._add_up()
            known = [self.right_with_slip, contacts.slip_stiffness, self.change]
            residual = solver.residual(*known)
            right = self._pairs.find_impulses(pairs, self._velocities, self.right, residual)
        self._ground.update(contacts, right, self.velocity_update, self.right_with_slip)
        if self._pairs is not None and pairs is not None:
            self._pairs.update(pairs, self._velocities, solver.counters, solver.scalars)
        self._ground.conclude(contacts)
        if self._pairs is not None and pairs is not None:
            self._pairs.conclude(pairs, solver.counters, self._ground.largest_violations)
            self._add_pair_frictions(contacts)

    def launch_choice_of_turning(self, state: State, contacts: Contacts) -> None:
        """Launch which bodies are in flight and turn, once contact has settled."""
        self.turning.launch_choice(state, contacts, self._flown(None))

    def launch_turning(
        self,
        state: State,
        contacts: Contacts,
        after: State,
        relinearise: Callable[[Any, Any, Any], None],
    ) -> None:
        """Launch the arcs of bodies in flight, once the straight paths stand in ``after``."""
        self.turning.launch(state, contacts, after, self._flown(relinearise))

    def _flown(self, relinearise: Callable[[Any, Any, Any], None] | None) -> Flown:
        ends = (self.right, self.outer_impulses, self.change)
        return Flown(*ends, self._found_pairs, self._balance.groups, relinearise)

    def launch_account(self, contacts: Contacts) -> None:
        """Launch the account of the step, once its contacts have their impulses."""
        normals = self._solver.normals
        moved = (self.outer_impulses, self.before, self.change)
        self.accountant.launch(contacts, normals, *moved, self._found_pairs)

    def read_statistics(self, *, renewed: bool, resolved: bool, fastest: float) -> StepStatistics:
        """What the step took; the arguments are passed on."""
        # as Python's own numbers: one by one NumPy's take as long as a kernel
        counters: list[int] = self._read_counters().tolist()
        passes = counters[Counter.PASSES] + counters[Counter.EARLIER_PASSES]
        passes = max(self._model.options.newton_iterations, passes)
        iterations = counters[Counter.TOTAL_ITERATIONS]
        settled = counters[Counter.CHANGED] == 0
        if self._renewing and (settled or not self._model.scene.has_ground_edges):
            # no preconditioner knows of pairs, so more is left to the iteration
            self.fresh = max(FRESH_ITERATIONS, iterations / passes)
        converged = counters[Counter.UNCONVERGED] == 0
        fresh = int(self.fresh * passes)
        self.preconditioner.used(iterations, fresh=fresh, converged=converged)
        options = self._model.options
        scalars: list[float] = self._read_scalars().tolist()
        target, floor = scalars[Scalar.TARGET_SQUARE], scalars[Scalar.FLOOR_SQUARE]
        eased = math.sqrt(target / floor) if 0.0 < floor < target < math.inf else 1.0
        dt = options.time_step
        signorini, coulomb = self._ground.read_violations().tolist()
        halvings, stalls = (0, 0) if self.newton is None else self.newton.read()
        worst = None if settled or self._pairs is None else self._pairs.worst()
        return unchecked(
            StepStatistics,
            iterations=iterations,
            passes=passes,
            touching=counters[Counter.TOUCHING],
            residual=options.solver_tolerance * eased,
            renewed=renewed,
            converged=converged,
            contact_converged=settled,
            finite=math.isfinite(scalars[Scalar.LAST_SQUARE]),
            resolved=resolved,
            fastest=fastest,
            signorini=signorini / dt,
            coulomb=coulomb / dt,
            worst_node=-1 if settled else self._ground.worst_node(),
            worst_pair=worst,
            halvings=halvings,
            stalled=stalls > 0,
        )
