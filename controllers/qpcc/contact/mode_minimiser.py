"""The minimiser of the objective on one choice of contact modes, and the QP that gave it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPProblem, QPSolution
from warp_softbody.controllers.qpcc.contact.force_elimination import ForceElimination, ModeSystem


@dataclass(frozen=True, kw_only=True)
class ModeMinimiser:
    """The minimiser on one choice of modes, in scaled units.

    Attributes:
        modes: one per contact.
        controls: (nu,) scaled.
        points: (K, 6), scaled (f, w) of each contact.
        compute_multipliers: computes ``multipliers`` when they are asked for.
        value: of the objective, in the problem's own unit.
        stationarity: dual residual of the QP, scaled; nan where no QP gave the point.
        reduced_qp: None where the forces were not eliminated.
    """

    modes: tuple[int, ...]
    controls: FloatArray
    points: FloatArray
    compute_multipliers: Callable[[], FloatArray]
    value: float
    stationarity: float
    reduced_qp: ReducedQP | None = None

    @cached_property
    def multipliers(self) -> FloatArray:
        """(K, 6), derivatives of the objective as each contact's (f, w) is shifted.

        Another mode whose cone contains the point offers descent exactly if the derivative along
        one of its extreme rays is negative.
        """
        return self.compute_multipliers()


@dataclass(frozen=True)
class ReducedQP:
    """The QP over the controls alone, forces eliminated, and its answer."""

    system: ModeSystem
    elimination: ForceElimination
    program: QPProblem
    solution: QPSolution
