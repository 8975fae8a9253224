"""What one step took."""

from __future__ import annotations

import time
from dataclasses import dataclass


class StepClock:
    """Wall times of the parts of one step.

    Attributes:
        seconds: by part, "assembly", "control", "solve" and "contact"; only those that were marked.
    """

    def __init__(self) -> None:
        """Begin to measure."""
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def mark(self, part: str) -> None:
        """Count the time since the last mark to a part."""
        now = time.perf_counter()
        self.seconds[part] = self.seconds.get(part, 0.0) + now - self._last
        self._last = now

    @property
    def total(self) -> float:
        """All that was marked, s."""
        return sum(self.seconds.values())


@dataclass(frozen=True)
class StepStatistics:
    """What one step took.

    Attributes:
        iterations: of conjugate gradients, all contact passes together.
        passes: active-set passes, 1 where no contact mode changed.
        touching: nodes in contact.
        residual: that the last linear solve was asked for, of its right-hand side.
        renewed: whether the preconditioner was factorised anew.
        converged: whether every linear solve reached its tolerance.
        contact_converged: whether the active set settled.
        finite: whether every velocity is a finite number.
        resolved: whether rounding of the farthest node's position is less than the shortest edge at
            rest; beyond it the shape is lost, though numbers are finite.
        fastest: largest component of a node's velocity after the step, m/s.
        signorini: largest violation of Signorini's condition by a node, N: an impulse that pulls
            at it, or the one that would stop it where it sinks, over dt (docs/contact.md).
        coulomb: largest violation of Coulomb's law, N: distance of a node's friction from the
            one that the law demands at its velocity and normal impulse, over dt.
        worst_node: the node of the larger of the two where contact did not settle; else -1.
        worst_pair: names of the two bodies whose contact missed the laws most, where contact did
            not settle and surfaces touch each other.
        halvings: of Newton steps that would have left more of the equations than was left.
        stalled: whether a Newton iteration ended that way too, so that the one before it was kept.
    """

    iterations: int
    passes: int
    touching: int
    residual: float
    renewed: bool
    converged: bool
    contact_converged: bool
    finite: bool
    resolved: bool
    fastest: float
    signorini: float
    coulomb: float
    worst_node: int
    worst_pair: tuple[str, str] | None = None
    halvings: int = 0
    stalled: bool = False

    @property
    def settled(self) -> bool:
        """Whether every linear solve reached its tolerance, and every contact its mode."""
        return self.converged and self.contact_converged
