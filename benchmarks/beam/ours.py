"""The cantilever stepped by this project."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from warp_softbody import Character, Scene, SimulationOptions, Stepper, build_model
from warp_softbody.accuracy.runs.peers.beam import GRAVITY, MATERIAL, Cantilever, StepReport
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import Precision
from warp_softbody.engine.state import Contacts, Control, State

MOST_ITERATIONS = 10_000


class OurBeam:
    """A model, its stepper and two states that are swapped."""

    def __init__(
        self, beam: Cantilever, time_step: float, precision: Precision, **options: Any
    ) -> None:
        """Build the model of a beam at rest; more options as in ``SimulationOptions``."""
        fixed = np.flatnonzero(beam.fixed).astype(np.int32)
        body = Character(name="beam", mesh=beam.mesh, material=MATERIAL, fixed=fixed)
        # the tolerance that peers are given too
        options.setdefault("tolerance", SimulationOptions(precision=precision).solver_tolerance)
        settings = SimulationOptions(
            time_step=time_step, precision=precision, max_iterations=MOST_ITERATIONS, **options
        )
        # the system that residuals are recomputed for is the warped one of linear tets
        self._plain = set(options) <= {"threads", "tolerance", "preconditioner"}
        model = build_model(Scene(character=body, gravity=(0.0, 0.0, -GRAVITY)), settings)
        self._stepper = Stepper(model)
        self._states = [State.at_rest(model), State.at_rest(model)]
        self._control, self._contacts = Control.slack(model), Contacts.none(model)

    def step(self) -> StepReport:
        """One step, as a user's own loop makes it."""
        now, after = self._states
        statistics = self._stepper.step(now, self._control, self._contacts, after)
        self._states.reverse()
        return StepReport(
            iterations=statistics.iterations,
            converged=statistics.converged and statistics.finite,
        )

    def assembly_ms(self) -> float:
        """``Stepper.assemble`` timed by itself; it changes nothing that the next step reads."""
        begun = time.perf_counter()
        self._stepper.assemble(self._states[0])
        return 1e3 * (time.perf_counter() - begun)

    def positions(self) -> FloatArray:
        """(n, 3) m, a copy."""
        return _numbers(self._states[0].positions)

    def state(self) -> tuple[FloatArray, FloatArray] | None:
        """Copies of positions, m, and velocities, m/s; None where the system is another."""
        if not self._plain:
            return None
        return self.positions(), _numbers(self._states[0].velocities)


def _numbers(array: Any) -> FloatArray:
    return np.array(array.numpy(), dtype=np.float64)
