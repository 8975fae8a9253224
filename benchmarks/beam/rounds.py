"""Times solvers side by side in turn, so that a change of the machine's speed hits all alike."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.beam.cantilever import TIME_STEP
from benchmarks.beam.solver import BeamSolver, Make
from warp_softbody.accuracy.runs.peers.beam import Cantilever, StepReport
from warp_softbody.accuracy.runs.peers.corotation import CorotationalSystem

STEPS_IN_TURN = 5
CHECKED_STEPS = 3


@dataclass
class Entrant:
    """A solver and what was measured of it.

    Attributes:
        solver: the beam, two steps after rest when the timing begins.
        setup_ms: model and first step, which is when graphs are captured.
        step_ms: of every timed step.
        assembly_ms: once a turn.
        reports: of every timed step.
        residuals: of the checked steps, or those that the solver itself told.
    """

    solver: BeamSolver
    setup_ms: float
    step_ms: list[float] = field(default_factory=list)
    assembly_ms: list[float] = field(default_factory=list)
    reports: list[StepReport] = field(default_factory=list)
    residuals: list[float] = field(default_factory=list)


def enter(make: Make, beam: Cantilever) -> Entrant:
    """Make a solver and let it take two steps, one for each of the states that a solver swaps."""
    begun = time.perf_counter()
    solver = make(beam, TIME_STEP)
    solver.step()
    setup_ms = 1e3 * (time.perf_counter() - begun)
    solver.step()
    return Entrant(solver, setup_ms)


def run_in_turn(
    entrants: list[Entrant],
    steps: int,
    system: CorotationalSystem,
    progress: Callable[[int], None],
) -> None:
    """Step each in turn, a few steps at a time, until all have made ``steps`` steps.

    The residuals of the first, the middle and the last step are recomputed by ``system`` where a
    solver solves that system; this is not timed.
    """
    checked = set(np.linspace(0, steps - 1, CHECKED_STEPS).astype(int).tolist())
    for first in range(0, steps, STEPS_IN_TURN):
        progress(first)
        for entrant in entrants:
            for number in range(first, min(first + STEPS_IN_TURN, steps)):
                _timed_step(entrant, system if number in checked else None)
            assembly = entrant.solver.assembly_ms()
            if assembly is not None:
                entrant.assembly_ms.append(assembly)


def _timed_step(entrant: Entrant, system: CorotationalSystem | None) -> None:
    solver = entrant.solver
    before = solver.state() if system else None
    begun = time.perf_counter()
    report = solver.step()
    entrant.step_ms.append(1e3 * (time.perf_counter() - begun))
    entrant.reports.append(report)
    if report.residual is not None:
        entrant.residuals.append(report.residual)
    after = solver.state() if system else None
    if system and before and after:
        entrant.residuals.append(system.residual(*before, after[1]))
