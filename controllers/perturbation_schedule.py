"""Which steps of a run go without kicks, the perturbations of the QPCC's local search.

Kicks cost most of a solve and mostly find nothing. They are left out where the steps before say so.
"""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.qpcc.result import QPCCResult, SolverOptions


class PerturbationSchedule:
    """Leaves kicks out after a calm step, and for a while where modes hold and kicks found nothing.

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
        self._left = 0

    @property
    def memory(self) -> tuple[bool, int]:
        """Whether the last step was calm, and how many go without kicks yet."""
        return self._calm, self._left

    @memory.setter
    def memory(self, memory: tuple[bool, int]) -> None:
        self._calm, self._left = memory

    def options(self) -> SolverOptions:
        """The options of the next solve."""
        if self._calm:
            return self._without
        return self._not_held if self._left > 0 else self.kicked

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
        left_out = was_calm or (held and self._left > 0)
        if not (held and usable):
            self._left = 0
        elif not was_calm:
            # modes that hold after kicks: these found nothing
            self._left = self._left - 1 if self._left > 0 else self._pause
        return left_out
