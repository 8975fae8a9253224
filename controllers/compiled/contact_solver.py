"""Warm solves of a step's QPCC by native code; what that leaves goes to ``solve_qpcc``."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT, STICK
from warp_softbody.controllers.qpcc.contact.objective import diagonal_is_clear
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.result import (
    ContactMultipliers,
    QPCCResult,
    QPCCStatus,
    SolverOptions,
)
from warp_softbody.controllers.qpcc.solve import solve_qpcc
from warp_softbody.device.host_program import DEVICE, HostProgram
from warp_softbody.device.kernel_loading import prepare
from warp_softbody.inputs.records import unchecked
from warp_softbody.kernels.control.contact_search import make_contact_search
from warp_softbody.kernels.control.search_layout import (
    COUNTS,
    MOST_OTHERS,
    NUMBERS,
    SearchFinding,
    SearchOutcome,
    SearchSetting,
    SearchSizes,
)

MOST_VISITS = 128
"""Choices of modes that a native solve has room for; what asks for more is left to NumPy."""

MOST_SIZES = 8
"""Sizes of problems whose arrays are kept."""

GIVEN = ("gradient", "lower", "upper", "squares", "diagonal", "friction", "factors", "directions")
"""Arrays of a problem that are handed over under their own names."""


class StepTerms(NamedTuple):
    """What the problem of a step is made of (``build_qpcc``), for q rows and K patches.

    Attributes:
        muscle_map: (q + 3K, nu), change of J v+ per metre of l_d.
        compliance: (q + 3K, q + 3K), of the rows.
        step_velocity: (q + 3K,), J v+ without muscles and contact.
        lengths, reaches, rest_lengths: (nu,) m, of the segments.
        activations: (nu,), of the step before.
        targets: (q,), of the objectives' rows.
        goal_weights: (q,), of their squares.
        gaps: (K,) m/s, distances of the patches from the ground over the time step.
        costs: of effort and of change, second derivatives for each segment.
        friction: (K,).
        factors: (K, m), on the friction by direction.
        directions: (m, 2), unit vectors.
        resting: segments that may not contract.
    """

    muscle_map: FloatArray
    compliance: FloatArray
    step_velocity: FloatArray
    lengths: FloatArray
    reaches: FloatArray
    rest_lengths: FloatArray
    activations: FloatArray
    targets: FloatArray
    goal_weights: FloatArray
    gaps: FloatArray
    costs: tuple[float, float]
    friction: FloatArray
    factors: FloatArray
    directions: FloatArray
    resting: tuple[int, ...]


STEP_ARRAYS = StepTerms._fields[:-1]
"""Arrays of a step that are handed over under their own names, before ``resting``."""


Sizes = tuple[int, int, int, int]
"""Numbers of controls, contacts, directions and rows."""

SearchBegin = tuple[Sizes, npt.NDArray[np.int32]]
"""Sizes of problems, and the controls (nu,) that are at a bound when the next solve begins."""


class SearchRooms:
    """Arrays of native solves, by the sizes of problems; they hold nothing between solves.

    Searches may share them that never solve at the same time.
    """

    def __init__(self) -> None:
        """No arrays yet; their kernel, which takes longest to compile, is begun early."""
        prepare(DEVICE, [make_contact_search().solve])
        self._rooms: dict[Sizes, _Room] = {}

    def of(self, sizes: Sizes) -> _Room:
        """Arrays for problems of such sizes."""
        room = self._rooms.get(sizes)
        if room is None:
            if len(self._rooms) >= MOST_SIZES:
                self._rooms.clear()
            m = sizes[2]
            room = _Room(SearchSizes(*sizes, 2 + 2 * m, max(m, 3), max(m, 5), MOST_VISITS))
            self._rooms[sizes] = room
        return room


class CompiledSearch:
    """``solve_qpcc`` of one step after another, native where a problem allows it.

    Each solve begins with the controls at a bound that the last one of its sizes ended with.

    Attributes:
        rooms: of the arrays.
    """

    def __init__(self, rooms: SearchRooms | None = None) -> None:
        """Solve in arrays of one's own, or in ``rooms`` shared with others."""
        self.rooms = SearchRooms() if rooms is None else rooms
        self._begins: dict[Sizes, npt.NDArray[np.int32]] = {}

    @property
    def memory(self) -> tuple[SearchBegin, ...]:
        """What is remembered from solve to solve, the oldest first."""
        return tuple((sizes, begin.copy()) for sizes, begin in self._begins.items())

    @memory.setter
    def memory(self, memory: tuple[SearchBegin, ...]) -> None:
        self._begins = {sizes: begin.copy() for sizes, begin in memory}

    def solve(
        self,
        problem: ContactQPCC,
        *,
        start: tuple[int, ...] | None,
        fallback_controls: FloatArray,
        touching: BoolArray,
        others: tuple[tuple[int, ...], ...] = (),
        options: SolverOptions,
    ) -> QPCCResult:
        """The result of ``solve_qpcc`` for the same arguments, to rounding."""
        found = None
        plain = len(problem.squares) > 0 and diagonal_is_clear(problem)
        begun = (start, others)
        if plain and _is_warm(*begun, options, problem.contact_count, len(problem.directions)):
            with self._room(sizes_of(problem)) as room:
                found = room.solve(problem, *begun, touching, options)
        if found is not None:
            return found
        return solve_qpcc(
            problem,
            start=start,
            fallback_controls=fallback_controls,
            touching=touching,
            others=others,
            options=options,
        )

    def solve_step(
        self,
        step: StepTerms,
        *,
        start: tuple[int, ...] | None,
        touching: BoolArray,
        others: tuple[tuple[int, ...], ...] = (),
        options: SolverOptions,
    ) -> QPCCResult | None:
        """The result of a step's problem, to rounding, without making that in NumPy.

        None where ``solve_qpcc`` has to be asked.
        """
        controls, rows, contacts = len(step.lengths), len(step.targets), len(step.friction)
        if not rows or not _is_warm(start, others, options, contacts, len(step.directions)):
            return None
        with self._room((controls, contacts, len(step.directions), rows)) as room:
            return room.solve_step(step, start, others, touching, options)

    @contextmanager
    def _room(self, sizes: Sizes) -> Iterator[_Room]:
        """Arrays for problems of such sizes, in which the solve begins where the last one ended."""
        begin = self._begins.get(sizes)
        if begin is None:
            if len(self._begins) >= MOST_SIZES:
                self._begins.clear()
            begin = self._begins[sizes] = np.zeros(sizes[0], dtype=np.int32)
        room = self.rooms.of(sizes)
        at_bound = room.counts["at_bound"]
        at_bound[...] = begin
        yield room
        begin[...] = at_bound


def sizes_of(problem: ContactQPCC) -> Sizes:
    """The sizes by which the arrays of a problem are found."""
    contacts, directions = problem.contact_count, len(problem.directions)
    return problem.control_count, contacts, directions, len(problem.squares)


def _is_warm(
    start: tuple[int, ...] | None,
    others: tuple[tuple[int, ...], ...],
    options: SolverOptions,
    contacts: int,
    directions: int,
) -> bool:
    """Whether the native code knows such solves: from known modes, and by no clock."""
    if options.time_limit != math.inf or options.bound or len(others) > MOST_OTHERS:
        return False
    if start is None and options.starts:
        return False
    return all(
        len(modes) == contacts
        and (not modes or (0 <= min(modes) and max(modes) < 2 + 2 * directions))
        for modes in (others if start is None else (start, *others))
    )


class _Room:
    """The arrays of one size of problems; a solve begins with the controls ``at_bound`` in them.

    ``numbers`` and ``counts`` are those of ``search_layout``, by name.
    """

    def __init__(self, sizes: SearchSizes) -> None:
        self._resting: tuple[int, ...] = ()
        self._asked: tuple[SolverOptions, bool, bool, int] | None = None
        numbers = {name: shape(sizes) for name, shape in NUMBERS.items()}
        counts = {name: shape(sizes) for name, shape in COUNTS.items()}
        program = HostProgram(numbers, counts)
        self._run = program.running(make_contact_search().solve, reads=[], writes=[])
        self.numbers, self.counts = program.numbers, program.counts
        self.counts["settings"][: len(sizes)] = sizes

    def solve(
        self,
        problem: ContactQPCC,
        start: tuple[int, ...] | None,
        others: tuple[tuple[int, ...], ...],
        touching: BoolArray,
        options: SolverOptions,
    ) -> QPCCResult | None:
        """The result, or None where the problem is left to the NumPy form."""
        begun = time.perf_counter()
        numbers = self.numbers
        for name in GIVEN:
            numbers[name][...] = getattr(problem, name)
        numbers["offset"][...] = problem.velocity_offset
        numbers["by_controls"][...] = problem.velocity_from_controls
        numbers["by_forces"][...] = problem.velocity_from_forces
        numbers["scalars"][0] = problem.constant
        return self._search(start, others, touching, options, begun, assembles=False)

    def solve_step(
        self,
        step: StepTerms,
        start: tuple[int, ...] | None,
        others: tuple[tuple[int, ...], ...],
        touching: BoolArray,
        options: SolverOptions,
    ) -> QPCCResult | None:
        """The result of the problem that a step makes, or None as in `solve`."""
        begun = time.perf_counter()
        numbers, resting = self.numbers, self.counts["resting"]
        for name, values in zip(STEP_ARRAYS, step[: len(STEP_ARRAYS)], strict=True):
            numbers[name][...] = values
        if step.resting != self._resting:
            resting[...] = 0
            resting[list(step.resting)] = 1
            self._resting = step.resting
        return self._search(start, others, touching, options, begun, assembles=True)

    def _search(
        self,
        start: tuple[int, ...] | None,
        others: tuple[tuple[int, ...], ...],
        touching: BoolArray,
        options: SolverOptions,
        begun: float,
        *,
        assembles: bool,
    ) -> QPCCResult | None:
        counts, asked = self.counts, (options, start is None, assembles, len(others))
        if asked != self._asked:
            self._asked = asked
            self.numbers["scalars"][1] = options.reach
            counts["settings"][SearchSetting.HAS_START :] = (
                *(start is not None, min(options.max_qps, 10**6), options.kicks, options.patience),
                *(options.kick_held, assembles, len(others)),
            )
        for place, modes in enumerate(others):
            counts["others"][place] = modes
        if start is not None:
            counts["start"][...] = start
        counts["still_modes"][...] = np.where(touching, STICK, LIFT)
        self._run()
        if counts["findings"][SearchFinding.STATUS] != SearchOutcome.FOUND:
            counts["at_bound"][...] = 0
            return None
        return self._result(options, begun)

    def _result(self, options: SolverOptions, begun: float) -> QPCCResult:
        numbers = self.numbers
        findings = self.counts["findings"].tolist()
        results: list[float] = numbers["results"].tolist()
        objective, off, feasibility, stationarity, speed, impulse, size = results
        stationary = findings[SearchFinding.STATIONARY]
        complete = findings[SearchFinding.COMPLETE]
        status = _status(bool(stationary), bool(complete))
        if not off <= options.tolerance:
            status = QPCCStatus.INACCURATE
        controls, slopes = numbers["controls"].copy(), numbers["weighed_contacts"]
        qps, found_next = findings[SearchFinding.QPS], findings[SearchFinding.NEXT]
        modes = tuple(self.counts["visit_modes"][findings[SearchFinding.BEST]].tolist())
        return unchecked(
            QPCCResult,
            x=np.concatenate([controls, numbers["shares"].reshape(-1)]),
            controls=controls,
            forces=numbers["impulses"].copy(),
            velocities=numbers["speeds"].copy(),
            modes=modes,
            others=tuple(map(tuple, self.counts["next_modes"][:found_next].tolist())),
            objective=objective,
            # without contacts this is one convex QP
            lower_bound=-math.inf if modes or not stationary else objective,
            complementarity=off,
            feasibility=feasibility,
            stationarity=stationarity,
            multipliers=unchecked(
                ContactMultipliers,
                force=slopes[:, :3] * (size / impulse),
                velocity=slopes[:, 3:] * (size / speed),
                controls=numbers["rest"] * (size / numbers["control_scale"]),
            ),
            qp_count=qps,
            seconds=time.perf_counter() - begun,
            status=status,
            message=f"{status.value}; {qps} QPs, complementarity {off:.1e}",
        )


def _status(stationary: bool, complete: bool) -> QPCCStatus:
    """What is known of a local minimum."""
    if stationary:
        return QPCCStatus.STRONGLY_STATIONARY
    return QPCCStatus.NO_IMPROVING_FLIP if complete else QPCCStatus.BUDGET
