"""What the QPCC solver is asked for and what it hands back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from warp_softbody.arrays import FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.qpcc.contact.mode_table import contact_mode
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import Value


class QPCCStatus(Enum):
    """What is known of the returned point; each value claims no more than it says."""

    GLOBAL = "least objective over every combination of modes"
    STRONGLY_STATIONARY = "local minimum: no piece that touches the point offers descent"
    NO_IMPROVING_FLIP = "no change of one mode was found to improve the point"
    BUDGET = "consistent point, improvement stopped by the budget of QPs or time"
    STATIC = "least objective with the modes of the static-contact baseline"
    FALLBACK_LCP = "forward contact solution at the fallback controls, objective ignored"
    INACCURATE = "the point misses the complementarity tolerance"
    NO_POINT = "no consistent point found within the budget; the point is not usable"
    INFEASIBLE = "no consistent point exists; the point is not usable"
    UNBOUNDED = "the objective falls without end along a ray from the point"

    @classmethod
    def _missing_(cls, value: object) -> QPCCStatus:
        """Refuse a value of none of them."""
        return input_kinds.member("QPCCStatus", value, cls)


@dataclass(frozen=True, kw_only=True)
class SolverOptions:
    """How much work one solve may do.

    Attributes:
        max_qps: QPs in one solve, >= 1.
        kicks: how often a local minimum is left by forcing one contact into another mode;
            each costs one to three QPs.
        patience: kicks in a row without a better minimum after which no more are tried.
        reach: contact form: how far above the best value, in shares of its size, a kick's first QP
            may end; beyond it the kick is given up, often before the QP is solved.
        kick_held: whether kicks are tried where a start's own modes are the best minimum without.
        starts: how many penalty runs from other points follow the first one, where no start is
            given; none of them with a warm start.
        time_limit: s; checked between QPs, so one QP may run over.
        tolerance: largest scaled complementarity residual that counts as consistent.
        qp_tolerance: accuracy asked of each QP in scaled units.
    """

    max_qps: int = 40
    kicks: int = 12
    patience: int = 3
    reach: float = math.inf
    kick_held: bool = True
    starts: int = 0
    time_limit: float = math.inf
    tolerance: float = 1e-8
    qp_tolerance: float = 1e-12

    def __post_init__(self) -> None:
        """Refuse budgets and tolerances that no solve could keep."""
        least = {"max_qps": 1, "kicks": 0, "patience": 0, "starts": 0}
        for name, low in least.items():
            count = checks.whole(f"SolverOptions.{name}", getattr(self, name), low=low)
            checks.keep(self, **{name: count})
        checks.settle(self, positive=("tolerance", "qp_tolerance"))
        for name in ("time_limit", "reach"):
            label, value = f"SolverOptions.{name}", getattr(self, name)
            checks.keep(self, **{name: checks.number(label, value, above=0.0, infinite=True)})
        checks.truth("SolverOptions.kick_held", self.kick_held)


WARM_OPTIONS = SolverOptions(patience=1, reach=1.0)
"""What a solve with a start may spend where nothing is said: mostly one kick that fails. Patience
of 3 without a limit of reach costs twice as much and gains a tenth of a percent (docs/qpcc.md)."""

COLD_OPTIONS = SolverOptions(max_qps=600, kicks=150, patience=150, starts=8)
"""What a solve without a start may spend where nothing is said."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class GeneralMultipliers(Value):
    """``Qx + c = A'equalities - G'inequalities + lower - upper + L'left + R'right``.

    ``inequalities``, ``lower`` and ``upper`` are nonnegative, and so are ``left`` and ``right``
    where that side of the pair is positive elsewhere in the piece; of a zero side the sign is free.
    """

    equalities: FloatArray
    inequalities: FloatArray
    lower: FloatArray
    upper: FloatArray
    left: FloatArray
    right: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ContactMultipliers(Value):
    """Slopes of the objective as a contact's (impulse, velocity) is shifted off the physics.

    Attributes:
        force: (K, 3), per N s.
        velocity: (K, 3), per m/s.
        controls: (nu,), what is left of the gradient: >= 0 at lower bounds, <= 0 at upper ones,
            zero between.
    """

    force: FloatArray
    velocity: FloatArray
    controls: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class GeneralResult(Value):
    """The point found, with residuals computed afresh from the full form of the problem.

    Attributes:
        x: the point; of a contact problem that of its general form (``full_form.to_full``).
        modes: piece of every pair (0: left side zero, 1: right side zero) or contact (pieces.py);
            pass it as ``start`` of the next solve.
        objective: at the point.
        complementarity: scaled, largest ``|min(left, right)|`` over all pairs.
        feasibility: largest violation of a bound, scaled equation or inequality.
        stationarity: scaled gradient of the Lagrangian of the point's piece, wrong signs of
            multipliers included; nan where no QP gave the point.
        multipliers: of the point's piece; None where no QP gave the point.
        qp_count: QPs solved, the infeasible ones included.
        seconds: wall time.
        status: what is known of the point.
        message: one sentence for people.
    """

    x: FloatArray
    modes: tuple[int, ...]
    objective: float
    complementarity: float
    feasibility: float
    stationarity: float
    multipliers: GeneralMultipliers | ContactMultipliers | None
    qp_count: int
    seconds: float
    status: QPCCStatus
    message: str


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class QPCCResult(GeneralResult):
    """The same for the contact form.

    Attributes:
        controls: (nu,), inside their bounds.
        forces: (K, 3) N s, local frame (normal, tangent 1, tangent 2).
        velocities: (K, 3) m/s, gap / dt included in the normal.
    """

    controls: FloatArray
    forces: FloatArray
    velocities: FloatArray

    @property
    def contact_modes(self) -> tuple[ContactMode, ...]:
        """Lift, stick or slide per contact."""
        return tuple(contact_mode(mode) for mode in self.modes)
