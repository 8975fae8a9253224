"""Contact of surfaces with each other: between bodies, and of a body with itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.device.warp_runtime import with_kernels
from warp_softbody.engine.contact_arrays import DelassusWork, FoundPairs, PassRecord
from warp_softbody.engine.ground_edges import GroundEdges
from warp_softbody.engine.model import Model
from warp_softbody.engine.pair_detection import PairDetection, mean_edges
from warp_softbody.engine.pair_ending import PairEnding
from warp_softbody.engine.state import PairStates, State
from warp_softbody.kernels.contact.pair_active_set import make_pair_active_set
from warp_softbody.kernels.contact.pair_constraints import make_pair_constraints
from warp_softbody.kernels.contact.pair_ending import Round
from warp_softbody.kernels.contact.pass_conclusion import make_pass_conclusion
from warp_softbody.kernels.contact.structs import make_contact_structs, make_pair_structs
from warp_softbody.linear.pcg import ConjugateGradients

APPROACH = 2e-6
"""Part of an edge's length by which a pair may close beyond its gap in a step and count as open."""


def slowest_approach(model: Model) -> float:
    """Speed at which a pair may close beyond its gap and count as open, m/s."""
    mesh = model.body.mesh
    edge = float(mean_edges(mesh.points, mesh.surface)[mesh.surface].min())
    return APPROACH * edge / model.options.time_step


@dataclass(frozen=True)
class StepVectors:
    """The vectors of a step that the ending of unsettled pairs works on.

    Attributes:
        right, right_with_slip: (n,) vec3 N s, as in `ContactSolver`.
        ground_frictions, slip_stiffness: those of `Contacts`, at nodes.
        before, change, velocities: (n,) vec3 m/s, before the step, what it adds, and their sum.
        add_up: launches the sum.
        take_difference: launches the change from the sum.
    """

    right: Any
    right_with_slip: Any
    ground_frictions: Any
    slip_stiffness: Any
    before: Any
    change: Any
    velocities: Any
    add_up: Callable[[], None]
    take_difference: Callable[[], None]


class PairContact:
    """Velocity constraints and active set of pairs; all launches but `find` can be captured.

    Attributes:
        found: the pairs that there are in a step.
        unsettled: (1,) int, pairs whose modes or frictions the last pass changed.
    """

    def __init__(self, model: Model, solver: ConjugateGradients, matrix: Any) -> None:
        """Work arrays; ``solver`` solves with ``matrix``, M~."""
        types, n = model.types, model.node_count
        count = PairStates.count(model)
        precision = model.options.precision
        self._model = model
        self._matrix = matrix
        self._rows = make_pair_constraints(precision)
        self._modes = make_pair_active_set(precision)
        self._conclusion = make_pass_conclusion(precision)
        self._structs = make_pair_structs(precision)
        structs = make_contact_structs(precision)
        self._states = structs.ContactStates
        self.found = FoundPairs.of(count, n, model.allocator)
        # factors of friction on the ground's edges are coefficients where there are no others
        self._friction = float(model.scene.body_friction) if model.scene.has_pairs else 1.0
        self._detection = PairDetection(model, self.found) if model.scene.has_pairs else None
        self._ground_edges: GroundEdges | None = None
        if model.scene.has_ground_edges:
            self._ground_edges = GroundEdges(model, self.found, self._friction)
        self._work = struct_of(
            self._structs.DelassusWork, DelassusWork.of(count, n, model.allocator)
        )
        self._constraints = solver.constraints
        self._right = model.zeros(n, types.vec3)
        self._ending = PairEnding(model, self._friction)
        self.unsettled = model.zeros(1, wp.int32)
        self._worst = model.zeros(1, wp.int32)
        self._largest_impulse = model.zeros(1, types.scalar)
        self._approach = slowest_approach(model)
        self._record = struct_of(structs.PassRecord, PassRecord.of(count, model.allocator))
        self._nodes: Any = None
        self._count = count

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any], dim: int = 1) -> None:
        device = self._model.options.device
        launch(kernel, dim, inputs, outputs, device)

    def find(self, state: State, pairs: PairStates, handled: Any = None) -> None:
        """Find the pairs of a step that starts from ``state``; what has no partner lifts.

        ``handled`` is that of `Control`.
        """
        self._nodes = pairs.nodes
        detection, edges = self._detection, self._ground_edges
        if detection is not None:
            with_kernels(lambda: detection.find(state, pairs, handled))
        if edges is not None:
            with_kernels(lambda: edges.find(state, pairs))

    @property
    def lists(self) -> list[Any]:
        """Numbers of the pairs that there are, and how many: (c,) int and (1,) int."""
        return [self.found.found, self.found.found_count]

    @property
    def normals(self) -> Any:
        """(c,) vec3 of the pairs found, unit, from the other side onto the node or edge."""
        return self.found.normals

    def _bound(self, pairs: PairStates) -> Any:
        """The struct of the pairs found, with the nodes and weights of the caller's states."""
        return struct_of(self._structs.Pairs, self.found, nodes=pairs.nodes, weights=pairs.weights)

    def _shared(self, pairs: PairStates) -> list[Any]:
        """What every kernel of the constraints takes first."""
        return [self._bound(pairs), pairs.modes, self._constraints]

    def impose(self, pairs: PairStates, x: Any) -> None:
        """Launch the list of active pairs, and the relative velocities that their modes give."""
        inputs = [pairs.modes, self._constraints]
        self._launch(self._rows.list_rows, inputs, [self._bound(pairs)])
        self._launch(self._rows.impose, self._shared(pairs), [self._work, x])

    def finish_residual(self, pairs: PairStates, x: Any, r: Any, partial: Any) -> None:
        """Launch r = P (b - matrix x) from the ground's S (b - M~ x)."""
        inputs = [*self._shared(pairs), pairs.slip_stiffness, x]
        self._launch(self._rows.finish_residual, inputs, [self._work, r, partial])

    def project(self, pairs: PairStates, v: Any) -> None:
        """Launch v = P v."""
        self._launch(self._rows.project_pairs, self._shared(pairs), [self._work, v])

    def finish_product(self, pairs: PairStates, p: Any, q: Any, partial: Any) -> None:
        """Launch q = P matrix p from the ground's S M~ p."""
        inputs = [*self._shared(pairs), pairs.slip_stiffness, p]
        self._launch(self._rows.finish_product, inputs, [self._work, q, partial])

    def find_impulses(self, pairs: PairStates, x: Any, right: Any, r: Any) -> Any:
        """Launch the pairs' impulses; the right side with them, as the ground's contacts see it."""
        inputs = [*self._shared(pairs), pairs.friction_forces, pairs.slip_stiffness, x, right]
        outputs = [self._work, r, pairs.impulses, self._right, self._largest_impulse]
        self._launch(self._modes.find_impulses, inputs, outputs)
        return self._right

    def update(self, pairs: PairStates, x: Any, counters: Any, scalars: Any) -> None:
        """Launch the choice of modes."""
        a = self._model.arrays
        law = [a.masses.fixed, a.pattern.diagonal_slot, self._friction, self._approach]
        inputs = [*law, self._bound(pairs), self._matrix, x, self._largest_impulse]
        inputs += [counters, scalars]
        outputs = [struct_of(self._states, pairs), self._record]
        self._launch(self._modes.update_pairs, inputs, outputs, dim=self._count)

    def add_frictions(
        self, pairs: PairStates, right: Any, ground_frictions: Any, right_with_slip: Any
    ) -> None:
        """Launch the right side with the friction forces of sliding pairs and nodes."""
        inputs = [self._bound(pairs), pairs.modes, pairs.friction_forces, right, ground_frictions]
        self._launch(self._modes.add_frictions, inputs, [right_with_slip])

    def conclude(self, pairs: PairStates, counters: Any, largest_violations: Any) -> None:
        """Launch the count of changes, after the ground's."""
        passes = self._model.options.max_contact_passes
        inputs = [passes, self._bound(pairs), pairs.modes, self._record]
        outputs = [counters, largest_violations, self._worst, self.unsettled]
        self._launch(self._conclusion.conclude_pairs, inputs, outputs)

    def worst(self) -> tuple[str, str] | None:
        """Names of the two bodies whose pair missed the laws most in the last pass, if any did."""
        slot = int(self._worst.numpy()[0])
        if slot < 0:
            return None
        scene, nodes = self._model.scene, self._nodes.numpy()[slot]
        # the other side's node is the third of an edge's pair, and one of the others of a node's
        if nodes[0] == nodes[2]:
            return scene.parts[scene.node_bodies[nodes[0]]].name, "the ground"
        first, second = scene.node_bodies[nodes[[0, 2]]]
        return scene.parts[first].name, scene.parts[second].name

    def end_safely(
        self,
        pairs: PairStates,
        solve: Callable[[PairStates | None], None],
        solver: ConjugateGradients,
        known: StepVectors,
    ) -> None:
        """Launch the end of a step whose pairs did not settle.

        Args:
            pairs: the caller's states; the impulses become those of the end.
            solve: launches a solve with the pairs of given states held, or with none.
            solver: of the step.
            known: what the step knows beside the pairs.
        """
        ending, bound = self._ending, self._bound(pairs)
        last = ending.begin(bound, pairs)

        def take_away() -> None:
            sides = [known.right, known.ground_frictions, known.right_with_slip]
            self.add_frictions(last, *sides)
            solve(last)
            known.add_up()
            residual = solver.residual(known.right_with_slip, known.slip_stiffness, known.change)
            self.find_impulses(last, known.velocities, known.right, residual)
            sides = [known.before, known.right, known.velocities]
            ending.prune(bound, last, self._largest_impulse, sides)

        wp.capture_while(ending.rounds[Round.AGAIN : Round.AGAIN + 1], take_away)
        ending.clip(bound, pairs)

        def give_forces() -> None:
            sides = [known.right, known.ground_frictions]
            wp.copy(known.change, solver.start)
            ending.add_impulses(bound, pairs, 0.0, sides, known.right_with_slip)
            solve(None)
            known.add_up()
            ending.keep(known.velocities)
            ending.add_impulses(bound, pairs, 1.0, sides, known.right_with_slip)
            solver.solve(known.right_with_slip, known.slip_stiffness, known.change)
            known.add_up()
            ending.end(bound, pairs, known.before, known.right, known.velocities)
            known.take_difference()

        wp.capture_if(ending.rounds[Round.TOO_FEW : Round.TOO_FEW + 1], give_forces)


class PairConstraints:
    """Pairs with the states of a step, as constraints on its solves."""

    def __init__(self, contact: PairContact, pairs: PairStates, velocities: Any) -> None:
        """Bind the caller's states, and the velocities (n,) vec3 m/s that a solve starts from."""
        self._contact = contact
        self._pairs = pairs
        self._velocities = velocities

    def finish_residual(self, r: Any, partial: Any) -> None:
        """See `Constraints`."""
        self._contact.finish_residual(self._pairs, self._velocities, r, partial)

    def project(self, v: Any) -> None:
        """See `Constraints`."""
        self._contact.project(self._pairs, v)

    def finish_product(self, p: Any, q: Any, partial: Any) -> None:
        """See `Constraints`."""
        self._contact.finish_product(self._pairs, p, q, partial)
