"""What one choice of contact modes gives: its minimiser and the QP that gave it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPProblem, QPSolution
from warp_softbody.controllers.qpcc.contact.mode_blocks import Elimination, Pieces


@dataclass(frozen=True, kw_only=True)
class Node:
    """The minimiser over one choice of modes, in scaled units.

    Attributes:
        modes: one per contact.
        controls: (nu,) scaled.
        points: (K, 6), scaled (f, w) of each contact.
        slopes_there: computes ``slopes``.
        value: objective, in the problem's own unit.
        stationarity: largest entry of the gradient of the QP's Lagrangian, scaled.
        origin: what ``ReducedProblem.polish`` needs; None where no reduced QP gave the point.
    """

    modes: tuple[int, ...]
    controls: FloatArray
    points: FloatArray
    slopes_there: Callable[[], FloatArray]
    value: float
    stationarity: float
    origin: Origin | None = None

    @cached_property
    def slopes(self) -> FloatArray:
        """(K, 6), slope of the objective as each contact's (f, w) is shifted.

        The piece of another mode that contains the point offers descent exactly if one of its
        rays does.
        """
        return self.slopes_there()


@dataclass(frozen=True)
class Origin:
    """The reduced QP that gave a node."""

    pieces: Pieces
    elimination: Elimination
    program: QPProblem
    solution: QPSolution
