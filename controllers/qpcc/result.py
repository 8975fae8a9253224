"""Options, statuses and results of the QPCC solver."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from warp_softbody.arrays import FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import Value


class QPCCStatus(Enum):
    """What is known of the returned point; no status claims more than its sentence."""

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

    @property
    def usable(self) -> bool:
        """Whether the result has a point that may be used."""
        return self not in (QPCCStatus.INFEASIBLE, QPCCStatus.NO_POINT, QPCCStatus.UNBOUNDED)

    @classmethod
    def _missing_(cls, value: object) -> QPCCStatus:
        """Refuse a value of none of them."""
        return input_kinds.member("QPCCStatus", value, cls)


@dataclass(frozen=True, kw_only=True)
class SolverOptions:
    """How much work one solve may do, and to what accuracy.

    Attributes:
        max_qps: most QPs in one solve, >= 1.
        kicks: most perturbations of a local minimum, in each of which one contact or pair is forced
            into another mode or to its other side, or all contacts that bear slide the same way;
            each costs one to three QPs. A cold solve of the contact form begins by four times as
            many, of which twice as many as ``patience`` may fail in a row.
        patience: kicks in a row without a better minimum after which no more are tried.
        reach: contact form: how far above the best value, relative to it, the first QP of a kick
            may end; beyond that the kick is given up, often before the QP is solved.
        kick_held: whether kicks are tried where the best minimum has the modes of the start.
        bound: contact form: whether a solve with a start gives a lower bound too, by one more QP in
            general form; others do anyway.
        starts: penalty runs from other points after the first one, where no start is given.
        time_limit: s; checked between QPs, so that one QP may run over.
        tolerance: largest scaled complementarity residual of a consistent point.
        qp_tolerance: scaled tolerance of each QP.
    """

    max_qps: int = 40
    kicks: int = 12
    patience: int = 3
    reach: float = math.inf
    kick_held: bool = True
    bound: bool = False
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
        checks.truth("SolverOptions.bound", self.bound)


WARM_OPTIONS = SolverOptions(patience=1, reach=1.0)
"""The default of a solve with a start: mostly one kick that fails. Patience of 3 without a limit of
reach costs twice as much and gains a tenth of a percent (docs/qpcc.md)."""

COLD_OPTIONS = SolverOptions(max_qps=2000, kicks=150, patience=150, starts=8)
"""The default of a solve without a start."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class GeneralMultipliers(Value):
    """``Qx + c = A'equalities - G'inequalities + lower - upper + L'left + R'right``.

    ``inequalities``, ``lower`` and ``upper`` are nonnegative, and so is the multiplier of that side
    of a pair that only has to be nonnegative on the piece; that of the zero side has any sign.
    """

    equalities: FloatArray
    inequalities: FloatArray
    lower: FloatArray
    upper: FloatArray
    left: FloatArray
    right: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ContactMultipliers(Value):
    """Derivatives of the objective as (impulse, velocity) of a contact is shifted in its law.

    Attributes:
        force: (K, 3), per N s.
        velocity: (K, 3), per m/s.
        controls: (nu,), of the bounds: >= 0 at lower bounds, <= 0 at upper ones, zero between.
    """

    force: FloatArray
    velocity: FloatArray
    controls: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class GeneralResult(Value):
    """The point found, with residuals computed anew from the problem with all pairs written out.

    Attributes:
        x: the point; of a contact problem that of its general form (``to_full``).
        modes: the zero side of every pair (0 left, 1 right), or the mode of every contact
            (``contact.mode_table``); to be passed as ``start`` of the next solve.
        objective: at the point.
        lower_bound: no consistent point has a lower objective, but for the accuracy of the QPs;
            minus infinity where nothing is known, plus infinity where there is no point.
        complementarity: largest scaled ``|min(left, right)|`` over all pairs.
        feasibility: largest violation of a bound, scaled equation or inequality.
        stationarity: scaled KKT residual on the point's piece, with wrong signs of multipliers;
            nan where no QP gave the point.
        multipliers: on the point's piece; None where no QP gave the point.
        qp_count: QPs solved, the infeasible ones included.
        seconds: wall time of the solve.
        status: what is known of the point.
        message: status and residual in a sentence.
        ray: along which the objective falls without end from the point, where that is the status.
    """

    x: FloatArray
    modes: tuple[int, ...]
    objective: float
    lower_bound: float
    complementarity: float
    feasibility: float
    stationarity: float
    multipliers: GeneralMultipliers | ContactMultipliers | None
    qp_count: int
    seconds: float
    status: QPCCStatus
    message: str
    ray: FloatArray | None = None

    @property
    def gap(self) -> float:
        """How far the bound is below the objective, relative to the larger of the two sizes.

        0 for a proved minimum, infinite where no bound or no point is known.
        """
        apart = self.objective - self.lower_bound
        if self.status is QPCCStatus.GLOBAL:
            return 0.0
        if not self.status.usable or not math.isfinite(apart):
            return math.inf
        size = max(abs(self.objective), abs(self.lower_bound))
        return apart / size if size > 0.0 else 0.0


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class QPCCResult(GeneralResult):
    """The result for the contact form.

    Attributes:
        controls: (nu,), inside their bounds.
        forces: (K, 3) N s, local frame (normal, tangent 1, tangent 2).
        velocities: (K, 3) m/s, gap / dt included in the normal.
        others: modes of the next best minima that the search came by, at most `OTHERS`, the best
            first; to be passed as ``others`` of the next solve.
    """

    controls: FloatArray
    forces: FloatArray
    velocities: FloatArray
    others: tuple[tuple[int, ...], ...] = ()

    @property
    def contact_modes(self) -> tuple[ContactMode, ...]:
        """Lift, stick or slide of every contact; all modes from the first slide on are sliding."""
        return tuple(ContactMode(min(mode, ContactMode.SLIDE)) for mode in self.modes)
