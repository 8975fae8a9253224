"""What a run shows of each step to those who observe it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from warp_softbody.controllers.control_solver import Decision
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.engine.step_statistics import StepStatistics


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class StepRecord:
    """A step that was taken; the device arrays are those of the run, and change with the next step.

    Attributes:
        index: of the step, from 0; those that a sleeping scene leaves out are counted too.
        time: at which it began, s.
        statistics: what it took.
        decision: of the controller; None where there is none, or it wanted nothing.
        before: the state that the step began in, as long as observers are called.
        state: the state that it led to.
        control: what acted in it.
        contacts: as it left them.
        seconds: wall time, s, of its parts "control", "assembly", "solve" and "contact".
    """

    index: int
    time: float
    statistics: StepStatistics
    decision: Decision | None
    before: State
    state: State
    control: Control
    contacts: Contacts
    seconds: Mapping[str, float]


StepObserver: TypeAlias = Callable[[StepRecord], None]
"""Called after every step that was taken, in the thread that steps."""
