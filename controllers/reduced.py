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

from dataclasses import replace

import numpy as np

from warp_softbody.controllers.blocks import (
    AffineForces,
    Blocks,
    definite,
    eliminate,
    gather,
)
from warp_softbody.controllers.node import Node, Origin
from warp_softbody.controllers.pieces import PieceTable, piece_table
from warp_softbody.controllers.qp import Backend, QPProblem, QPSolution, QPStatus, polish
from warp_softbody.controllers.qpcc import ContactQPCC, FloatArray

AT_BOUND = 1e-9
"""Scaled distance within which a control is at its bound."""


class ReducedProblem:
    """A problem scaled once, from which the QP of any modes is built in a few matrix products."""

    def __init__(self, problem: ContactQPCC, backend: Backend) -> None:
        """Scale the problem and look up its pieces."""
        self.problem = problem
        self.backend = backend
        self.table: PieceTable = piece_table(problem)
        nu, k = problem.control_count, problem.contact_count
        half = 0.5 * (problem.upper - problem.lower)
        self.control_scale = np.where(np.isfinite(half) & (half > 0.0), half, 1.0)
        self.speed, self.impulse = problem.scales
        scale = np.concatenate([self.control_scale, np.full(3 * k, self.impulse)])
        hessian = problem.hessian * scale[:, None] * scale
        hessian = 0.5 * (hessian + hessian.T)
        gradient = problem.gradient * scale
        curvature = float(np.max(np.diagonal(hessian)[:nu]))
        self.value_scale = curvature or float(np.max(np.abs(gradient))) or 1.0
        hessian /= self.value_scale
        self._gradient = gradient / self.value_scale
        self._uu, self._ff = hessian[:nu, :nu], hessian[nu:, nu:]
        self._fu, self._uf = hessian[nu:, :nu], hessian[:nu, nu:]
        self._hessian = hessian
        self.lower = problem.lower / self.control_scale
        self.upper = problem.upper / self.control_scale
        # Column 0 is the constant, columns 1.. the controls: every affine map here has this shape.
        self.free = np.empty((3 * k, nu + 1))
        self.free[:, 0] = problem.velocity_offset / self.speed
        self.free[:, 1:] = problem.velocity_from_controls * (self.control_scale / self.speed)
        self.mobility = problem.velocity_from_forces * (self.impulse / self.speed)
        self._well_posed = definite(self.mobility)

    def solve(self, modes: tuple[int, ...]) -> Node | None:
        """Minimise over these modes; None where they are infeasible or the QP was not solved."""
        pieces = gather(self.table, modes)
        forces = eliminate(pieces, self.free, self.mobility, self._well_posed)
        if forces is None:
            return self._solve_kept(modes, pieces)
        return self._solve_reduced(modes, pieces, forces)

    def forces_at(self, modes: tuple[int, ...], controls: FloatArray) -> FloatArray | None:
        """(3K,) scaled forces of these modes at fixed scaled controls; None if not determined."""
        pieces = gather(self.table, modes)
        forces = eliminate(pieces, self.free, self.mobility, self._well_posed)
        return None if forces is None else forces.at(controls)

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
        self, modes: tuple[int, ...], pieces: Blocks, forces: AffineForces
    ) -> Node | None:
        """The QP in the controls only."""
        affine = forces.affine
        offset, slope = affine[:, 0], affine[:, 1:]
        half = slope.T @ (self._fu + 0.5 * (self._ff @ slope))
        nu = len(self.lower)
        linear = self._gradient[:nu] + self._uf @ offset
        linear += (self._gradient[nu:] + self._ff @ offset) @ slope
        velocity = self.free + self.mobility @ affine
        rows = pieces.test(affine, velocity)
        program = QPProblem(
            P=self._uu + half + half.T,
            c=linear,
            A=np.zeros((0, nu)),
            b=np.zeros(0),
            G=rows[:, 1:],
            h=-rows[:, 0],
            lower=self.lower,
            upper=self.upper,
        )
        solution = self.backend.solve(program)
        if solution.status is not QPStatus.SOLVED:
            return None
        return self._reduced_node(modes, Origin(pieces, forces, program, solution))

    def multipliers(self, node: Node) -> tuple[FloatArray, FloatArray, float]:
        """Slopes (K, 6), what is left of the controls' gradient, and the stationarity residual.

        Scaled, and computed from the point and its velocity slopes alone: the residual takes in
        the gradient off its bounds, slopes against the piece's rays, and slopes that do work.
        """
        nu, force = len(self.lower), node.points[:, :3].reshape(-1)
        on_velocity = node.slopes[:, 3:].reshape(-1)
        slopes = self._shifted(self._force_gradient(node.controls, force), on_velocity)
        rest = self._gradient[:nu] + self._uu @ node.controls + self._uf @ force
        rest = rest - on_velocity @ self.free[:, 1:]
        at_lower = node.controls <= self.lower + AT_BOUND
        at_upper = node.controls >= self.upper - AT_BOUND
        off = np.where(at_lower, np.minimum(rest, 0.0), rest)
        off = np.where(at_upper, np.maximum(off, 0.0), off)
        worst = float(np.abs(off).max(initial=0.0))
        if len(node.modes):
            own = self.table.descent(slopes)[np.arange(len(node.modes)), list(node.modes)]
            work = np.abs(np.einsum("ki,ki->k", slopes, node.points))
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
        pieces, forces, solution = origin.pieces, origin.forces, origin.solution
        controls, multipliers = solution.x, solution.multipliers.rows
        force = forces.at(controls)
        # The multipliers of the still rows, by the transposed system.
        push, pull = pieces.press(multipliers)
        gradient = self._force_gradient(controls, force)
        held = ((gradient - push - pull @ self.mobility) @ pieces.basis) @ forces.inverse
        slopes = self._shifted(gradient, pull + pieces.pull(held))
        return self._node(modes, controls, force, slopes, solution, origin)

    def _solve_kept(self, modes: tuple[int, ...], pieces: Blocks) -> Node | None:
        """The QP in controls and force amplitudes, for singular T Wf E."""
        nu, count = len(self.lower), pieces.basis.shape[1]
        lift = np.zeros((len(self._gradient), nu + count))
        lift[:nu, :nu] = np.eye(nu)
        lift[nu:, nu:] = pieces.basis
        moved = np.hstack([self.free, self.mobility @ pieces.basis])
        force_map = np.hstack([np.zeros_like(self.free), pieces.basis])
        rows, still = pieces.test(force_map, moved), pieces.hold(moved)
        free = np.full(count, np.inf)
        solution = self.backend.solve(
            QPProblem(
                P=lift.T @ self._hessian @ lift,
                c=lift.T @ self._gradient,
                A=still[:, 1:],
                b=-still[:, 0],
                G=rows[:, 1:],
                h=-rows[:, 0],
                lower=np.concatenate([self.lower, -free]),
                upper=np.concatenate([self.upper, free]),
            )
        )
        if solution.status is not QPStatus.SOLVED:
            return None
        controls, force = solution.x[:nu], pieces.basis @ solution.x[nu:]
        multipliers = solution.multipliers.rows
        on_velocity = pieces.pull(solution.multipliers.equalities) + pieces.press(multipliers)[1]
        slopes = self._shifted(self._force_gradient(controls, force), on_velocity)
        return self._node(modes, controls, force, slopes, solution, None)

    def _shifted(self, gradient: FloatArray, on_velocity: FloatArray) -> FloatArray:
        """Join the slope in w with the slope in f that the physics w = .. + Wf f leaves."""
        on_force = gradient - self.mobility.T @ on_velocity
        return np.concatenate([on_force.reshape(-1, 3), on_velocity.reshape(-1, 3)], axis=1)

    def _force_gradient(self, controls: FloatArray, force: FloatArray) -> FloatArray:
        nu = len(self.lower)
        gradient: FloatArray = self._gradient[nu:] + self._fu @ controls + self._ff @ force
        return gradient

    def _node(
        self,
        modes: tuple[int, ...],
        controls: FloatArray,
        force: FloatArray,
        slopes: FloatArray,
        solution: QPSolution,
        origin: Origin | None,
    ) -> Node:
        z = np.concatenate([controls, force])
        value = float(z @ (0.5 * (self._hessian @ z) + self._gradient))
        return Node(
            modes=modes,
            controls=controls,
            points=self.points_at(controls, force),
            slopes=slopes,
            value=value * self.value_scale + self.problem.constant,
            violation=solution.primal_residual,
            stationarity=solution.dual_residual,
            origin=origin,
        )
