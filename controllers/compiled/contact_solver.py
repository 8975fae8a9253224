"""Warm solves of a step's QPCC by native code; what that leaves goes to ``solve_qpcc``."""

from __future__ import annotations

import math
import time

import numpy as np

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
from warp_softbody.device.host_program import HostProgram
from warp_softbody.inputs.records import unchecked
from warp_softbody.kernels.control.contact_search import make_contact_search
from warp_softbody.kernels.control.search_layout import (
    COUNTS,
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


class CompiledSearch:
    """``solve_qpcc`` of one step after another, native where a problem allows it."""

    def __init__(self) -> None:
        """No arrays yet."""
        self._rooms: dict[SearchSizes, _Room] = {}

    def solve(
        self,
        problem: ContactQPCC,
        *,
        start: tuple[int, ...] | None,
        fallback_controls: FloatArray,
        touching: BoolArray,
        options: SolverOptions,
    ) -> QPCCResult:
        """The result of ``solve_qpcc`` for the same arguments, to rounding."""
        found = None
        if _is_plain(problem, start, options):
            found = self._room(problem).solve(problem, start, touching, options)
        if found is not None:
            return found
        return solve_qpcc(
            problem,
            start=start,
            fallback_controls=fallback_controls,
            touching=touching,
            options=options,
        )

    def _room(self, problem: ContactQPCC) -> _Room:
        """Arrays for problems of this one's sizes."""
        m = len(problem.directions)
        sizes = SearchSizes(
            *(problem.control_count, problem.contact_count, m, len(problem.squares)),
            *(2 + 2 * m, max(m, 3), max(m, 5), MOST_VISITS),
        )
        room = self._rooms.get(sizes)
        if room is None:
            if len(self._rooms) >= MOST_SIZES:
                self._rooms.clear()
            room = self._rooms[sizes] = _Room(sizes)
        return room


def _is_plain(problem: ContactQPCC, start: tuple[int, ...] | None, options: SolverOptions) -> bool:
    """Whether the native code knows such problems: squares, finite ranges, no clock."""
    cold = start is None and options.starts
    modes = 2 + 2 * len(problem.directions)
    known = start is None or (
        len(start) == problem.contact_count and all(0 <= mode < modes for mode in start)
    )
    return (
        known
        and not cold
        and options.time_limit == math.inf
        and len(problem.squares) > 0
        and diagonal_is_clear(problem)
    )


class _Room:
    """The arrays of one size of problems, in which each solve begins where the last one ended.

    ``numbers`` and ``counts`` are those of ``search_layout``, by name.
    """

    def __init__(self, sizes: SearchSizes) -> None:
        numbers = {name: shape(sizes) for name, shape in NUMBERS.items()}
        counts = {name: shape(sizes) for name, shape in COUNTS.items()}
        self._program = HostProgram(make_contact_search().solve, numbers, counts)
        self.numbers, self.counts = self._program.numbers, self._program.counts
        self.counts["settings"][: len(sizes)] = sizes

    def solve(
        self,
        problem: ContactQPCC,
        start: tuple[int, ...] | None,
        touching: BoolArray,
        options: SolverOptions,
    ) -> QPCCResult | None:
        """The result, or None where the problem is left to the NumPy form."""
        begun = time.perf_counter()
        numbers, counts = self.numbers, self.counts
        for name in GIVEN:
            numbers[name][...] = getattr(problem, name)
        numbers["offset"][...] = problem.velocity_offset
        numbers["by_controls"][...] = problem.velocity_from_controls
        numbers["by_forces"][...] = problem.velocity_from_forces
        numbers["scalars"][...] = problem.constant, options.reach
        counts["settings"][SearchSetting.HAS_START :] = (
            *(start is not None, min(options.max_qps, 10**6), options.kicks, options.patience),
            options.kick_held,
        )
        if start is not None:
            counts["start"][...] = start
        counts["still_modes"][...] = np.where(touching, STICK, LIFT)
        self._program.run()
        if counts["findings"][SearchFinding.STATUS] != SearchOutcome.FOUND:
            counts["at_bound"][...] = 0
            return None
        return self._result(problem, options, begun)

    def _result(self, problem: ContactQPCC, options: SolverOptions, begun: float) -> QPCCResult:
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
        qps = findings[SearchFinding.QPS]
        return unchecked(
            QPCCResult,
            x=np.concatenate([controls, numbers["shares"].reshape(-1)]),
            controls=controls,
            forces=numbers["impulses"].copy(),
            velocities=numbers["speeds"].copy(),
            modes=tuple(self.counts["visit_modes"][findings[SearchFinding.BEST]].tolist()),
            objective=objective,
            lower_bound=-math.inf,
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
