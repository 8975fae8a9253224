"""Which steps of a run go without kicks: where the last steps say that none will find anything."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.controllers.qpcc.result import QPCCResult, SolverOptions

CALM = 0.01
"""Objective below which a step counts as calm; in the units of the shipped controllers, momentum
rows over m g dt, it stands for a missing force of a tenth of the weight."""

HELD = 8
"""Steps of the same modes that follow one whose kicks found nothing, and go without."""


class KickRule:
    """A calm step leaves nothing worth looking for, and modes that hold found nothing just now."""

    def __init__(self) -> None:
        """Nothing is known yet."""
        self._calm = False
        self._left = 0

    def options(self, kicked: SolverOptions, calm: SolverOptions) -> SolverOptions:
        """Of the next solve: some of its own where the last one was calm, else ``kicked``."""
        if self._calm:
            return calm
        return replace(kicked, kick_held=False) if self._left > 0 else kicked

    def note(self, start: tuple[int, ...] | None, result: QPCCResult, usable: bool) -> bool:
        """Learn from the solve that was begun at ``start``; whether it went without kicks."""
        was_calm, held = self._calm, start is not None and result.modes == start
        self._calm = usable and result.objective < CALM
        left_out = was_calm or (held and self._left > 0)
        if not (held and usable):
            self._left = 0
        elif not was_calm:
            # modes that hold after kicks: these found nothing
            self._left = self._left - 1 if self._left > 0 else HELD
        return left_out
