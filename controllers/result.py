"""What the QPCC solver is asked for and what it hands back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from warp_softbody.controllers.pieces import contact_mode
from warp_softbody.controllers.qpcc import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.frame import ContactMode


class QPCCStatus(Enum):
    """What is known of the returned point; each value claims no more than it says."""

    GLOBAL = "least objective over every combination of modes"
    STRONGLY_STATIONARY = "local minimum: no piece that touches the point offers descent"
    NO_IMPROVING_FLIP = "no change of one contact's mode was found to improve the point"
    BUDGET = "consistent point, improvement stopped by the budget of QPs or time"
    STATIC = "least objective with the modes of the static-contact baseline"
    FALLBACK_LCP = "forward contact solution at the fallback controls, objective ignored"
    INACCURATE = "the point misses the complementarity tolerance"
    INFEASIBLE = "no consistent point found; forces are not usable"


@dataclass(frozen=True, kw_only=True)
class SolverOptions:
    """How much work one solve may do.

    Attributes:
        max_qps: QPs in one solve, >= 1.
        kicks: how often a local minimum is left by forcing one contact into another mode;
            each costs one to three QPs. With a warm start 2 a step left a mean gap of a quarter
            of a percent; cold, 12 are worth having.
        time_limit: s; checked between QPs, so one QP may run over.
        tolerance: largest scaled complementarity residual that counts as consistent.
        qp_tolerance: accuracy asked of each QP in scaled units.
    """

    max_qps: int = 40
    kicks: int = 12
    time_limit: float = math.inf
    tolerance: float = 1e-8
    qp_tolerance: float = 1e-12

    def __post_init__(self) -> None:
        """Refuse budgets and tolerances that no solve could keep."""
        if self.max_qps < 1:
            raise InputError(f"solver max_qps must be at least 1, got {self.max_qps!r}")
        if self.kicks < 0:
            raise InputError(f"solver kicks must not be negative, got {self.kicks!r}")
        for name in ("time_limit", "tolerance", "qp_tolerance"):
            if not getattr(self, name) > 0.0:
                raise InputError(f"solver {name} must be positive, got {getattr(self, name)!r}")


@dataclass(frozen=True, kw_only=True)
class QPCCResult:
    """The point found, with residuals computed afresh from the full form of the problem.

    Attributes:
        controls: (nu,), inside their bounds.
        forces: (K, 3) N s, local frame (normal, tangent 1, tangent 2).
        velocities: (K, 3) m/s, gap / dt included in the normal.
        modes: piece number per contact; pass it as ``start`` of the next step.
        objective: at (controls, forces).
        complementarity: scaled, largest ``|min(left, right)|`` over all pairs.
        feasibility: largest violation of a bound of the controls.
        stationarity: scaled gradient of the last QP's Lagrangian; nan where no QP gave the point.
        qp_count: QPs solved, the infeasible ones included.
        seconds: wall time.
        status: what is known of the point.
        message: one sentence for people.
    """

    controls: FloatArray
    forces: FloatArray
    velocities: FloatArray
    modes: tuple[int, ...]
    objective: float
    complementarity: float
    feasibility: float
    stationarity: float
    qp_count: int
    seconds: float
    status: QPCCStatus
    message: str

    @property
    def contact_modes(self) -> tuple[ContactMode, ...]:
        """Lift, stick or slide per contact."""
        return tuple(contact_mode(mode) for mode in self.modes)
