"""What a controller wanted of the last step, what came of it, and what the muscles could reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.authority import response

if TYPE_CHECKING:
    from warp_softbody.controllers.control_solver import Decision

DIGITS = 4
"""Of numbers in a table."""


@dataclass(frozen=True, kw_only=True)
class GoalOutcome:
    """One row of an objective in one step, in the units of the row.

    Attributes:
        objective: its name.
        row: number of the row in the objective.
        weight: of its square.
        wanted: its target.
        planned: what the plan came to; another one may have weighed more.
        reached: what the step came to; of a plan that looks further ahead, what it comes to if the
            body goes on as in the step.
        low, high: least and greatest value that the muscles reach with the contact modes of the
            plan, if this row alone counts.
    """

    objective: str
    row: int
    weight: float
    wanted: float
    planned: float
    reached: float
    low: float
    high: float

    @property
    def reachable(self) -> float:
        """The value within reach that is nearest to the wanted one."""
        return min(max(self.wanted, self.low), self.high)


@dataclass(frozen=True, kw_only=True)
class GoalReport:
    """Of one step.

    Attributes:
        time: at which it began, s.
        outcomes: of all rows of all objectives.
        motion: that was on, of a sequence of them; None of a controller that has one.
    """

    time: float
    outcomes: tuple[GoalOutcome, ...]
    motion: str | None = None

    def __str__(self) -> str:
        """A table, a row a line."""
        heads = ("objective", "weight", "wanted", "planned", "reached", "reachable")
        lines: list[tuple[str, ...]] = [heads]
        for own in self.outcomes:
            numbers = (own.weight, own.wanted, own.planned, own.reached, own.reachable)
            lines.append(
                (f"{own.objective} {own.row}", *(f"{number:.{DIGITS}g}" for number in numbers))
            )
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        table = (
            "  ".join(
                text.ljust(width) if place == 0 else text.rjust(width)
                for place, (text, width) in enumerate(zip(line, widths, strict=True))
            )
            for line in lines
        )
        motion = "" if self.motion is None else f", in the motion {self.motion!r}"
        return "\n".join((f"step at {self.time:.4g} s{motion}", *table))


def goal_report(
    decision: Decision, velocities: FloatArray, motion: str | None = None
) -> GoalReport:
    """Of a decision, the velocities (n, 3) m/s that came of it, and the motion that was on."""
    goals, maps, result = decision.goals, decision.maps, decision.result
    count = sum(len(objective.rows) for objective in goals.objectives)
    view, chosen = decision.view, decision.lengths_ahead - maps.lengths
    impulses = np.asarray(result.forces).ravel()
    planned = maps.free_velocity[:count] + maps.muscle_map[:count] @ chosen
    planned = planned + maps.compliance[:count, count : count + len(impulses)] @ impulses
    gaps = np.array([patch.gap for patch in goals.patches]) / view.horizon
    modes = result.contact_modes if len(result.modes) == len(goals.patches) else ()
    low, high = response(maps, count, modes, gaps, np.asarray(result.forces)).range(maps)
    outcomes, begin = [], 0
    velocities = view.at_horizon(view.velocities, velocities)
    for objective in goals.objectives:
        reached = objective.rows @ velocities.ravel()
        for row, value in enumerate(reached):
            at = begin + row
            outcomes.append(
                GoalOutcome(
                    objective=objective.name,
                    row=row,
                    weight=float(objective.weight[row]),
                    wanted=float(objective.target[row]),
                    planned=float(planned[at]),
                    reached=float(value),
                    low=float(low[at]),
                    high=float(high[at]),
                )
            )
        begin += len(reached)
    return GoalReport(time=view.time, outcomes=tuple(outcomes), motion=motion)
