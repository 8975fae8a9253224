"""One QP per choice of contact modes, contact forces eliminated (docs/method.md section 5).

With the piece of every contact fixed, forces are ``f = E y`` and ``T w = 0``: one small square
system ``(T Wf E) y = -T (w0 + Wu u)`` makes them affine in the controls, and the QP that is left
has only the controls as variables. Where that system is singular (redundant contacts) the QP
keeps y as variables and the system as equations instead, which is exact, only slower.

Everything here is scaled: controls by their range, forces and velocities by
``ContactQPCC.scales``, the objective by its largest curvature, so that one tolerance serves every
row.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qp.problem import QPProblem, QPSolver, QPStatus, polish
from warp_softbody.controllers.qpcc.contact.mode_blocks import (
    ContactMaps,
    Elimination,
    Pieces,
    contradicts,
    definite,
    eliminate,
)
from warp_softbody.controllers.qpcc.contact.mode_qp import Node, Origin
from warp_softbody.controllers.qpcc.contact.mode_table import PieceTable, piece_table
from warp_softbody.controllers.qpcc.contact.objective import Eliminated, scaled_quadratic
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC

AT_BOUND = 1e-9
"""Scaled distance within which a control is at its bound."""


CONSISTENT = 1e-8
"""Scaled residual of rows above which redundant contacts have no common point."""


class ReducedProblem:
    """A problem scaled once, from which the QP of any modes is built in a few matrix products."""

    def __init__(self, problem: ContactQPCC, qp_solver: QPSolver) -> None:
        """Scale the problem and look up its pieces."""
        self.problem = problem
        self.qp_solver = qp_solver
        self.qp_count = 0
        self.table: PieceTable = piece_table(problem)
        nu, k = problem.control_count, problem.contact_count
        half = 0.5 * (problem.upper - problem.lower)
        self.control_scale = np.where(np.isfinite(half) & (half > 0.0), half, 1.0)
        self.speed, self.impulse = problem.scales
        scale = np.concatenate([self.control_scale, np.full(3 * k, self.impulse)])
        self.objective, self.value_scale = scaled_quadratic(problem, scale)
        self.lower = problem.lower / self.control_scale
        self.upper = problem.upper / self.control_scale
        # Column 0 is the constant, columns 1.. the controls: every affine map here has this shape.
        self.free = np.empty((3 * k, nu + 1))
        self.free[:, 0] = problem.velocity_offset / self.speed
        self.free[:, 1:] = problem.velocity_from_controls * (self.control_scale / self.speed)
        self.mobility = problem.velocity_from_forces * (self.impulse / self.speed)
        self._maps = ContactMaps(self.table, self.free, self.mobility, self.objective.outputs)
        self._well_posed = definite(self.mobility)
        self._no_rows, self._no_sides = np.zeros((0, nu)), np.zeros(0)

    def solve(self, modes: tuple[int, ...], limit: float = math.inf) -> Node | None:
        """Minimise over these modes; None where they are infeasible or the QP was not solved.

        None too where no value is as low as ``limit``, if that shows early.
        """
        pieces = self._maps.gather(modes)
        elimination = eliminate(pieces, self._maps, self._well_posed)
        if elimination is None:
            return self._solve_kept(modes, pieces)
        return self._solve_reduced(modes, pieces, elimination, limit)

    def forces_at(self, modes: tuple[int, ...], controls: FloatArray) -> FloatArray | None:
        """(3K,) scaled forces of these modes at fixed scaled controls; None if not determined."""
        found = eliminate(self._maps.gather(modes), self._maps, self._well_posed)
        return None if found is None else found.affine[:, 0] + found.affine[:, 1:] @ controls

    def points_at(self, controls: FloatArray, force: FloatArray) -> FloatArray:
        """(K, 6) scaled (f, w) of every contact for scaled controls and forces."""
        velocity = self.free[:, 0] + self.free[:, 1:] @ controls + self.mobility @ force
        return np.concatenate([force.reshape(-1, 3), velocity.reshape(-1, 3)], axis=1)

    def unscale(self, controls: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Controls, inside their bounds, and forces (K, 3) in the problem's units."""
        own = self.problem
        u = np.minimum(np.maximum(controls * self.control_scale, own.lower), own.upper)
        return u, points[:, :3] * self.impulse

    def _solve_reduced(
        self, modes: tuple[int, ...], pieces: Pieces, elimination: Elimination, limit: float
    ) -> Node | None:
        """The QP in the controls only."""
        objective = self.objective.eliminated(elimination)
        cutoff = math.inf if limit == math.inf else self._cutoff(objective, limit)
        if cutoff < 0.0:
            return None
        rows = pieces.test(elimination.both)
        program = QPProblem(
            P=objective.P,
            c=objective.c,
            A=self._no_rows,
            b=self._no_sides,
            G=np.ascontiguousarray(rows[:, 1:]),
            h=-rows[:, 0],
            lower=self.lower,
            upper=self.upper,
            cutoff=cutoff,
        )
        self.qp_count += 1
        solution = self.qp_solver.solve(program)
        if solution.status is not QPStatus.SOLVED or solution.primal_residual > CONSISTENT:
            return None
        return self._reduced_node(modes, Origin(pieces, elimination, program, solution))

    def _cutoff(self, objective: Eliminated, limit: float) -> float:
        """From the least value without rows and bounds up to the limit, scaled."""
        least = objective.least
        if least is None:
            return math.inf
        return (limit - self.problem.constant) / self.value_scale - least

    def multipliers(self, node: Node) -> tuple[FloatArray, FloatArray, float]:
        """Slopes (K, 6), what is left of the controls' gradient, and the stationarity residual.

        Scaled, and computed from the point and its velocity slopes alone: the residual takes in
        the gradient off its bounds, slopes against the piece's rays, and slopes that do work.
        """
        nu, force = len(self.lower), node.points[:, :3].reshape(-1)
        on_velocity = node.slopes[:, 3:].reshape(-1)
        z = np.concatenate([node.controls, force])
        gradient = self.objective.times(z) + self.objective.c
        slopes = _per_contact(gradient[nu:] - on_velocity @ self.mobility, on_velocity)
        rest = gradient[:nu] - on_velocity @ self.free[:, 1:]
        at_lower = node.controls <= self.lower + AT_BOUND
        at_upper = node.controls >= self.upper - AT_BOUND
        off = np.where(at_lower, np.minimum(rest, 0.0), rest)
        off = np.where(at_upper, np.maximum(off, 0.0), off)
        worst = float(np.abs(off).max(initial=0.0))
        if len(node.modes):
            own = self.table.rays[np.arange(len(node.modes)), node.modes] @ slopes[:, :, None]
            work = np.abs((slopes * node.points).sum(axis=1))
            worst = max(worst, -float(own.min()), float(work.max()))
        return slopes, rest, worst

    def polish(self, node: Node) -> Node:
        """The node with its controls to rounding, where its active set is clear."""
        if node.origin is None:
            return node
        solution = polish(node.origin.program, node.origin.solution)
        if solution is node.origin.solution:
            return node
        return self._reduced_node(node.modes, replace(node.origin, solution=solution))

    def _reduced_node(self, modes: tuple[int, ...], origin: Origin) -> Node:
        solution, both = origin.solution, origin.elimination.both
        points = (both[:, 0] + both[:, 1:] @ solution.x).reshape(-1, 6)
        value, gradient = self._value(solution.x, points)
        return Node(
            modes=modes,
            controls=solution.x,
            points=points,
            slopes_there=partial(self._reduced_slopes, origin, gradient),
            value=value,
            stationarity=solution.dual_residual,
            origin=origin,
        )

    def _reduced_slopes(self, origin: Origin, gradient: FloatArray) -> FloatArray:
        """Slopes of a reduced QP's node; the multipliers of T w = 0 by the transposed system."""
        pieces, width = origin.pieces, self.free.shape[1]
        push, pull = pieces.press(origin.solution.multipliers.rows)
        pressed = gradient - pull @ self.mobility
        held = origin.elimination.held(pieces.basis @ (pressed - push))
        back = (held @ pieces.still[:, width:]).reshape(2, -1)
        return _per_contact(pressed - back[0], pull + back[1])

    def _solve_kept(self, modes: tuple[int, ...], pieces: Pieces) -> Node | None:
        """The QP in controls and force amplitudes, for singular T Wf E."""
        nu, k = len(self.lower), len(self.mobility)
        if contradicts(pieces, k, self.lower, self.upper):
            return None
        count = len(pieces.basis)
        lift = np.zeros((nu + k, nu + count))
        lift[:nu, :nu] = np.eye(nu)
        lift[nu:, nu:] = pieces.basis.T
        held = pieces.still[:, 1 + nu : 1 + nu + k] @ pieces.basis.T
        both = [self._maps.base[k : 3 * k], pieces.spread[:, k : 3 * k].T]
        rows = pieces.test(np.concatenate(both, axis=1))
        free = np.full(count, np.inf)
        self.qp_count += 1
        solution = self.qp_solver.solve(
            QPProblem(
                P=lift.T @ self.objective.matrix() @ lift,
                c=lift.T @ self.objective.c,
                A=np.concatenate([pieces.still[:, 1 : 1 + nu], held], axis=1),
                b=-pieces.still[:, 0],
                G=rows[:, 1:],
                h=-rows[:, 0],
                lower=np.concatenate([self.lower, -free]),
                upper=np.concatenate([self.upper, free]),
            )
        )
        if solution.status is not QPStatus.SOLVED or solution.primal_residual > CONSISTENT:
            return None
        controls, force = solution.x[:nu], pieces.basis.T @ solution.x[nu:]
        points = self.points_at(controls, force)
        value, gradient = self._value(controls, points)
        on_velocity = solution.multipliers.equalities @ pieces.still[:, 1 + nu + k :]
        on_velocity = on_velocity + pieces.press(solution.multipliers.rows)[1]
        slopes = _per_contact(gradient - on_velocity @ self.mobility, on_velocity)
        return Node(
            modes=modes,
            controls=controls,
            points=points,
            slopes_there=lambda: slopes,
            value=value,
            stationarity=solution.dual_residual,
        )

    def _value(self, controls: FloatArray, points: FloatArray) -> tuple[float, FloatArray]:
        """The objective in the problem's unit, and its scaled slope in the forces, (3K,)."""
        z = np.concatenate([controls, points[:, :3].reshape(-1)])
        slope, c = self.objective.times(z), self.objective.c
        value = (0.5 * float(z @ slope) + float(z @ c)) * self.value_scale + self.problem.constant
        return value, (slope + c)[len(controls) :]


def _per_contact(on_force: FloatArray, on_velocity: FloatArray) -> FloatArray:
    """(K, 6) from slopes in all forces and in all velocities."""
    return np.concatenate([on_force.reshape(-1, 3), on_velocity.reshape(-1, 3)], axis=1)
