"""Which steps of a run go without kicks, the perturbations of the QPCC's local search.

Kicks cost most of a solve and mostly find nothing: on recorded steps of sixteen runs something
better in 9 % of those whose descent left the modes of the start, in 5 % of those whose modes had
held for up to eight steps, and in 1 % of later ones. They are left out where they promise least.
"""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.qpcc.result import QPCCResult, SolverOptions


class PerturbationSchedule:
    """Leaves most kicks out where modes have held for a while, and after a calm step.

    Attributes:
        kicked: what a solve with kicks may spend.
    """

    def __init__(self, options: ControlOptions, kicked: SolverOptions | None = None) -> None:
        """Nothing is known yet; ``kicked`` is by default what the options say."""
        self.kicked = kicked or SolverOptions(
            max_qps=options.max_qps,
            kicks=options.kicks,
            patience=options.kick_patience,
            reach=options.kick_reach,
        )
        self._without = replace(self.kicked, kicks=0)
        self._not_held = replace(self.kicked, kick_held=False)
        self._calm_objective = options.calm_objective
        self._pause = options.kick_pause
        self._calm = False
        self._held = 0

    @property
    def _pausing(self) -> bool:
        """Whether modes have held for a pause, in which one step tries kicks, and not this one."""
        return 0 < self._pause <= self._held and (self._held + 1) % self._pause != 0

    @property
    def memory(self) -> tuple[bool, int]:
        """Whether the last step was calm, and for how many steps modes have held."""
        return self._calm, self._held

    @memory.setter
    def memory(self, memory: tuple[bool, int]) -> None:
        self._calm, self._held = memory

    def options(self) -> SolverOptions:
        """The options of the next solve."""
        if self._calm:
            return self._without
        return self._not_held if self._pausing else self.kicked

    def retry(self, result: QPCCResult) -> SolverOptions | None:
        """The options of another solve of the step, where it was taken for calm and is not.

        One that begins at modes without a point may end far above the step before it.
        """
        if not self._calm or (result.status.usable and result.objective < self._calm_objective):
            return None
        self._calm = False
        return self.kicked

    def note(self, start: tuple[int, ...] | None, result: QPCCResult, usable: bool) -> bool:
        """Learn from a solve that began at ``start``; whether it went without kicks."""
        was_calm, held = self._calm, start is not None and result.modes == start
        self._calm = usable and result.objective < self._calm_objective
        left_out = was_calm or (held and self._pausing)
        if not (held and usable):
            self._held = 0
        elif not was_calm:
            self._held += 1
        return left_out
