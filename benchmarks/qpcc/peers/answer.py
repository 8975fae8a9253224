"""What another solver says of a QPCC."""

from __future__ import annotations

from dataclasses import dataclass

from warp_softbody.arrays import FloatArray


@dataclass(frozen=True, kw_only=True)
class PeerAnswer:
    """An answer, as it came.

    Attributes:
        verdict: "optimal" (proved), "point" (no proof), "infeasible", "unbounded", or "none".
        x: the point, None without one.
        seconds: CPU time.
        bound: proved lower bound of the objective, minus infinity without one.
    """

    verdict: str
    x: FloatArray | None
    seconds: float
    bound: float = float("-inf")
