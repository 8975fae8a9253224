"""What the rounds of a benchmark ask of each solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from warp_softbody.accuracy.runs.peers.beam import Cantilever, StepReport
from warp_softbody.arrays import FloatArray


class BeamSolver(Protocol):
    """A beam that can be stepped; made from a ``Cantilever`` and a time step in s."""

    def step(self) -> StepReport:
        """Advance by one time step."""

    def assembly_ms(self) -> float | None:
        """Time of forces and matrix alone at the present state, ms; None where it is not apart."""

    def positions(self) -> FloatArray:
        """(n, 3) m, a copy."""

    def state(self) -> tuple[FloatArray, FloatArray] | None:
        """Copies of positions, m, and velocities, m/s; None if its system is another."""


Make = Callable[[Cantilever, float], BeamSolver]
"""Makes a beam at rest with a time step in s."""

SETTLING_STEP = 0.5
SETTLED = 1e-5
MOST_SETTLING_STEPS = 60


def static_sag(make: Make, beam: Cantilever) -> float | None:
    """Fall of the tip face at rest, m; None if it did not come to rest.

    Equilibrium does not depend on the time step, and implicit steps of half a second damp the
    slowest swing (6 rad/s) by two thirds each. At rest: when the fall changes by less than
    ``SETTLED`` of itself in a step, so that what remains to come is about half of that.
    """
    solver = make(beam, SETTLING_STEP)
    last = 0.0
    for _ in range(MOST_SETTLING_STEPS):
        solver.step()
        sag = beam.fall(solver.positions())
        if abs(sag - last) < SETTLED * abs(sag):
            return sag
        last = sag
    return None
