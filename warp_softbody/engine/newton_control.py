"""Newton iterations of a step that never leave more of its equations than the iterate before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import warp as wp

from warp_softbody.device.host_view import HostView
from warp_softbody.device.launching import launch
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, PairStates
from warp_softbody.kernels.flight.groups import make_flight_groups
from warp_softbody.kernels.newton.base import make_newton_base
from warp_softbody.kernels.newton.codes import NewtonCount, NewtonScalar
from warp_softbody.kernels.newton.iterates import make_newton_iterates
from warp_softbody.kernels.newton.verdicts import make_newton_verdicts
from warp_softbody.linear.pcg import ConjugateGradients


@dataclass(frozen=True, eq=False)
class Iterate:
    """What Newton's method moves, and how.

    Attributes:
        change: (n,) vec3 m/s, what the step adds to the velocities.
        moved: struct of the velocities before the step and their change.
        right: (n,) vec3 N s, known impulses, without contact, of the equations as linearised last.
        held: (n,) int, not 0 for nodes whose velocities are given.
        placed: (n,) vec3 m, where the nodes are when the equations have been linearised.
        linearise: launches matrix and ``right`` about the present velocities.
        solve: launches the change that solves them, and its impulses of contact.
        contacts: with these impulses; None where nothing touches.
        found: numbers of the pairs that there are, and how many; None where there are none.
        carry: (2 bodies,) vec3d, what the solve carries over to the next step; None for nothing.
    """

    change: Any
    moved: Any
    right: Any
    held: Any
    placed: Any
    linearise: Callable[[], None]
    solve: Callable[[], None]
    contacts: Contacts | None = None
    found: list[Any] | None = None
    carry: Any = None


class NewtonControl:
    """Halves Newton steps until they leave less of the equations; launches are capturable.

    Of a step that no halving mends the iterate before it is kept, and iterations end
    (docs/method.md section 1).

    Attributes:
        merits: (iterations,) float64 J, of the iterates accepted in the last step.
    """

    def __init__(self, model: Model, values: Any, solver: ConjugateGradients) -> None:
        """Work arrays for the matrix in ``values``; ``solver`` knows its rows."""
        n, vec3 = model.node_count, model.types.vec3
        self._model, self._values, self._rows = model, values, solver.rows
        self._kernels = make_newton_iterates(model.options.precision)
        self._bases = make_newton_base(model.options.precision)
        self._verdicts = make_newton_verdicts(model.options.precision)
        chunks = model.system.chunk_count
        self._partial, self._roundings = (model.zeros(chunks, wp.float64) for _ in range(2))
        self._known, self._base, self._drift = (model.zeros(n, vec3) for _ in range(3))
        pairs = PairStates.count(model) if model.has_pairs else 0
        sizes = (n, model.contact_count, pairs)
        self._of_first = [model.zeros(size, vec3) for size in sizes]
        self._of_last = [model.zeros(size, vec3) for size in sizes]
        self._spread: Any = None
        if model.has_pairs:
            self._spread = make_flight_groups(model.options.precision).spread_impulses
            self._pushes = model.zeros(n, vec3)
        self._counters = model.zeros(len(NewtonCount), wp.int32)
        self._scalars = model.zeros(len(NewtonScalar), wp.float64)
        self.merits = model.zeros(model.options.newton_iterations, wp.float64)
        self._read = HostView(self._counters).read

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, dim, inputs, outputs, self._model.options.device)

    def _when(self, slot: NewtonCount) -> Any:
        return self._counters[slot : slot + 1]

    def launch_reset(self) -> None:
        """Launch the beginning of a time step."""
        self._counters.zero_()

    def launch(self, iterate: Iterate) -> None:
        """Launch all iterations but the first, whose change and impulses are there."""
        k, state = self._verdicts, [self._scalars, self._counters]
        self._copy(self._of_first, self._moving(iterate))
        self._note_left(iterate)
        self._launch_base(iterate)
        self._launch(k.begin, 1, [self._partial], state)
        self._judge(iterate)
        self._go_on(iterate)
        self._launch(k.conclude, 1, [self._roundings, self._scalars], [self._counters])
        diverged = self._when(NewtonCount.DIVERGED)
        wp.capture_if(diverged, lambda: self._try_again(iterate))

    def _launch_base(self, iterate: Iterate) -> None:
        """Launch the base of the first iterate, and what it leaves of the same equations."""
        inputs = [self._model.arrays.step.body_start, self._rows, iterate.held]
        inputs += [iterate.right, iterate.moved]
        outputs = [self._known, self._base, self._drift, self._scalars]
        self._launch(self._bases.find_base, 1, inputs, outputs)
        wp.copy(iterate.change, self._base)
        self._launch_measure(iterate)
        wp.copy(iterate.change, self._of_first[0])

    @staticmethod
    def _copy(to: list[Any], values: list[Any]) -> None:
        for one, other in zip(to, values, strict=False):
            wp.copy(one, other)

    def _go_on(self, iterate: Iterate) -> None:
        """Launch the iterations after the first, as long as they lead on."""
        for _ in range(self._model.options.newton_iterations - 1):
            wp.capture_if(self._when(NewtonCount.GO_ON), lambda: self._iterate(iterate))

    def _try_again(self, iterate: Iterate) -> None:
        """Launch all iterations anew, from a part of the way that led to the first iterate."""
        k, moving = self._verdicts, self._moving(iterate)
        state = [self._scalars, self._counters]
        wp.copy(self._of_last[0], self._base)
        for shared, values in zip(self._of_last[1:], self._of_first[1:], strict=True):
            self._launch(self._bases.take_share, len(values), [self._scalars, values], [shared])

        def measure_base() -> None:
            self._copy(moving, self._of_last)
            iterate.linearise()
            self._measure(iterate)

        def start_from_base() -> None:
            measure_base()
            self._launch(k.resume, 1, [self._partial], [*state, self.merits])

        self._mend(iterate)
        measure_base()
        self._launch(k.begin_again, 1, [self._partial], state)
        drifts = self._when(NewtonCount.DRIFTS)
        wp.capture_if(drifts, lambda: wp.copy(self._of_last[0], self._drift))
        self._copy(moving, self._of_first)
        self._shorten(iterate)
        wp.capture_if(self._when(NewtonCount.STALLED), start_from_base)
        self._go_on(iterate)

    def _iterate(self, iterate: Iterate) -> None:
        """Launch an iteration about the iterate that the equations are linearised at."""
        moving = self._moving(iterate)
        self._copy(self._of_last, moving)
        iterate.solve()
        self._note_left(iterate)
        self._judge(iterate)
        self._shorten(iterate)

        def restore() -> None:
            self._copy(moving, self._of_last)
            self._mend(iterate)

        wp.capture_if(self._when(NewtonCount.STALLED), restore)

    def _mend(self, iterate: Iterate) -> None:
        """Launch the removal of what is no number from what the last solve has left behind."""
        if iterate.carry is not None:
            self._launch(self._kernels.mend_carry, len(iterate.carry), [], [iterate.carry])
        contacts = iterate.contacts
        for states in (contacts, None if contacts is None else contacts.pairs):
            if states is not None:
                for vectors in (states.friction_forces, states.slip_velocities):
                    mended = [vectors, states.slip_stiffness]
                    self._launch(self._kernels.mend, len(vectors), [], mended)

    def _shorten(self, iterate: Iterate) -> None:
        """Launch halvings of the way from the last iterate, while they are due."""

        def halve() -> None:
            for last, values in zip(self._of_last, self._moving(iterate), strict=False):
                self._launch(self._kernels.halve, len(values), [last], [values])
            self._judge(iterate)

        wp.capture_while(self._when(NewtonCount.HALVE), halve)

    def _moving(self, iterate: Iterate) -> list[Any]:
        """What belongs to an iterate, the change first."""
        contacts = iterate.contacts
        if contacts is None:
            return [iterate.change]
        moving = [iterate.change, contacts.impulses]
        return moving if contacts.pairs is None else [*moving, contacts.pairs.impulses]

    def _note_left(self, iterate: Iterate) -> None:
        """Launch what the solve has left of the equations that it solved."""
        self._measure(iterate)
        self._launch(self._verdicts.note_left, 1, [self._partial], [self._scalars])

    def _judge(self, iterate: Iterate) -> None:
        """Launch the equations about an iterate, and the verdict on it."""
        iterate.linearise()
        self._measure(iterate)
        outputs = [self._scalars, self._counters, self.merits]
        self._launch(self._verdicts.judge, 1, [self._partial, self._roundings], outputs)

    def _measure(self, iterate: Iterate) -> None:
        """Launch what an iterate leaves of the equations as they are linearised."""
        m, k, contacts = self._model, self._kernels, iterate.contacts
        wp.copy(self._known, iterate.right)
        if contacts is not None and m.arrays.ground is not None:
            inputs = [m.arrays.ground.nodes, contacts.impulses]
            self._launch(k.add_impulses, m.contact_count, inputs, [self._known])
        if contacts is not None and contacts.pairs is not None:
            pairs, starts = contacts.pairs, m.arrays.step.body_start
            inputs = [starts, *(iterate.found or []), pairs.nodes, pairs.weights, pairs.impulses]
            self._launch(self._spread, len(m.scene.parts), inputs, [self._pushes])
            self._launch(k.add_pushes, m.node_count, [self._pushes], [self._known])
        self._launch_measure(iterate)

    def _launch_measure(self, iterate: Iterate) -> None:
        """Launch the same of an iterate for which the known impulses are there."""
        m, k = self._model, self._kernels
        inputs = [m.system.chunk, self._rows, m.arrays.step.factors, iterate.held]
        inputs += [self._values, self._known, iterate.moved, iterate.placed]
        outputs = [self._partial, self._roundings]
        self._launch(k.measure, m.system.chunk_count, inputs, outputs)

    def read(self) -> tuple[int, int]:
        """Halvings of the last step, and iterations of it that none served."""
        counters = self._read()
        return int(counters[NewtonCount.ALL_HALVINGS]), int(counters[NewtonCount.ALL_STALLS])
