"""What a stability case sets in motion, and our stepper doing so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from benchmarks.stability.measures import Accuracy, StateProbe, StateSample
from benchmarks.stability.starts import Begin
from warp_softbody import Character, Plane, Scene, SimulationOptions, Stepper, build_model
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.option_choice import with_choices
from warp_softbody.engine.state import Contacts, Control, State

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class CaseSetup:
    """What is run, but for the options under comparison.

    Attributes:
        make: the body.
        starts: the states it is released from, one run each.
        time_step: s.
        steps: of one run.
        pulled: steps at the begin in which all muscles pull in full; slack thereafter.
        ground, gravity: of the scene.
    """

    make: Callable[[], Character]
    starts: tuple[Begin, ...]
    time_step: float
    steps: int
    pulled: int = 0
    ground: Plane | None = None
    gravity: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class StepNote:
    """What a step says of itself."""

    iterations: int
    converged: bool
    finite: bool


class Mover(Protocol):
    """A body in motion: ours, or another program's."""

    character: Character
    probe: StateProbe
    accuracy: Accuracy

    @property
    def positions(self) -> FloatArray:
        """(n, 3) m, a copy."""

    @property
    def velocities(self) -> FloatArray:
        """(n, 3) m/s, a copy."""

    def pull(self, share: float) -> None:
        """Set l_d / l_0 of all muscles."""

    def step(self) -> StepNote:
        """One step. The state stays where its numbers are not finite."""

    def sample(self) -> StateSample:
        """Measure the state."""


class OurBody:
    """A model with its stepper and two states that are swapped."""

    def __init__(self, setting: CaseSetup, begin: Begin, overrides: dict[str, Any]) -> None:
        """Build the model under options and put the body where it starts."""
        self.character = setting.make()
        options = SimulationOptions(**{"time_step": setting.time_step, **overrides})
        scene = Scene(character=self.character, ground=setting.ground, gravity=setting.gravity)
        options = with_choices(options, scene)
        # what energy and spin may do is derived from a tolerance
        options = replace(options, tolerance=options.solver_tolerance)
        self.probe = StateProbe(self.character, setting.gravity)
        self.accuracy = Accuracy(
            time_step=options.time_step,
            tolerance=options.solver_tolerance,
            epsilon=float(np.finfo(np.dtype(options.precision)).eps),
        )
        self._model = build_model(scene, options)
        self._stepper = Stepper(self._model)
        self._states = [State.at_rest(self._model), State.at_rest(self._model)]
        self._control, self._contacts = Control.slack(self._model), Contacts.none(self._model)
        start = begin(self.character)
        self._states[0].positions.assign(start.positions)
        self._states[0].velocities.assign(start.velocities)

    @property
    def positions(self) -> FloatArray:
        """(n, 3) m, a copy."""
        return np.array(self._states[0].positions.numpy(), dtype=np.float64)

    @property
    def velocities(self) -> FloatArray:
        """(n, 3) m/s, a copy."""
        return np.array(self._states[0].velocities.numpy(), dtype=np.float64)

    def pull(self, share: float) -> None:
        """Set l_d / l_0 of all muscles."""
        self._control.rest_lengths.assign(share * self._model.muscles.rest_lengths)

    def step(self) -> StepNote:
        """One step. The state stays where its numbers are not finite."""
        now, after = self._states
        statistics = self._stepper.step(now, self._control, self._contacts, after)
        if statistics.finite:
            self._states.reverse()
        return StepNote(
            iterations=statistics.iterations,
            converged=statistics.converged and statistics.contact_converged,
            finite=statistics.finite,
        )

    def sample(self) -> StateSample:
        """Measure the state."""
        return self.probe.sample(self.positions, self.velocities, self.accuracy)
