"""What one choice of contact modes gives: its minimiser and the QP that gave it."""

from __future__ import annotations

from dataclasses import dataclass

from warp_softbody.controllers.blocks import AffineForces, Blocks
from warp_softbody.controllers.qp import QPProblem, QPSolution
from warp_softbody.controllers.qpcc import FloatArray


@dataclass(frozen=True, kw_only=True)
class Node:
    """The minimiser over one choice of modes, in scaled units.

    Attributes:
        modes: one per contact.
        controls: (nu,) scaled.
        points: (K, 6), scaled (f, w) of each contact.
        slopes: (K, 6), slope of the objective as each contact's (f, w) is shifted: the piece of
            another mode that contains the point offers descent exactly if one of its rays does.
        value: objective, in the problem's own unit.
        violation: largest violation of the pieces' rows, scaled.
        stationarity: largest entry of the gradient of the QP's Lagrangian, scaled.
        origin: what ``ReducedProblem.polish`` needs; None where no reduced QP gave the point.
    """

    modes: tuple[int, ...]
    controls: FloatArray
    points: FloatArray
    slopes: FloatArray
    value: float
    violation: float
    stationarity: float
    origin: Origin | None = None


@dataclass(frozen=True)
class Origin:
    """The reduced QP that gave a node."""

    pieces: Blocks
    forces: AffineForces
    program: QPProblem
    solution: QPSolution
