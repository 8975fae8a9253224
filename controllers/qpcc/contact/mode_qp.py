"""The convex QP of each choice of contact modes (docs/method.md section 5).

The contact forces are eliminated, so that the controls are its only variables. Where the system
that determines the forces is singular (redundant contacts) the QP has the amplitudes of the forces
as variables too and that system as equalities, which is exact, only slower.

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
from warp_softbody.controllers.qpcc.contact.force_elimination import (
    ContactMaps,
    ForceElimination,
    ModeSystem,
    eliminate,
    is_definite,
    is_inconsistent,
)
from warp_softbody.controllers.qpcc.contact.mode_minimiser import ModeMinimiser, ReducedQP
from warp_softbody.controllers.qpcc.contact.mode_table import ModeTable, mode_table
from warp_softbody.controllers.qpcc.contact.objective import ReducedObjective, scaled_objective
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC

CONSISTENT = 1e-8
"""Largest scaled primal residual of a QP with a point; redundant contacts may have none."""


class ScaledContactQPCC:
    """A contact problem in scaled units, which builds, solves and counts the QPs of its modes.

    Attributes:
        problem: in its own units.
        qp_count: QPs solved.
        table: cones of the modes.
        control_scale: (nu,), of the controls; ``speed`` and ``impulse`` are those of the contacts.
        value_scale: of the objective.
        objective: over the scaled controls and forces.
        free_velocity: (3K, 1 + nu), affine map of the contact velocities at zero force.
        delassus: (3K, 3K), contact velocities per contact force.
    """

    def __init__(self, problem: ContactQPCC, qp_solver: QPSolver) -> None:
        """Scale the problem and look up the cones of its modes."""
        self.problem = problem
        self.qp_solver = qp_solver
        self.qp_count = 0
        self.table: ModeTable = mode_table(problem)
        nu, k = problem.control_count, problem.contact_count
        half = 0.5 * (problem.upper - problem.lower)
        self.control_scale = np.where(np.isfinite(half) & (half > 0.0), half, 1.0)
        self.speed, self.impulse = problem.scales
        scale = np.concatenate([self.control_scale, np.full(3 * k, self.impulse)])
        self.objective, self.value_scale = scaled_objective(problem, scale)
        self.lower = problem.lower / self.control_scale
        self.upper = problem.upper / self.control_scale
        self.free_velocity = np.empty((3 * k, nu + 1))
        self.free_velocity[:, 0] = problem.velocity_offset / self.speed
        self.free_velocity[:, 1:] = problem.velocity_from_controls * (
            self.control_scale / self.speed
        )
        self.delassus = problem.velocity_from_forces * (self.impulse / self.speed)
        self._maps = ContactMaps(
            self.table, self.free_velocity, self.delassus, self.objective.outputs
        )
        self._delassus_definite = is_definite(self.delassus)
        self._no_rows, self._no_values = np.zeros((0, nu)), np.zeros(0)

    def solve(self, modes: tuple[int, ...], limit: float = math.inf) -> ModeMinimiser | None:
        """The minimiser on these modes; None where they are infeasible or the QP was not solved.

        It may be None, too, where the minimum is above ``limit``, if that shows early.
        """
        system = self._maps.system(modes)
        elimination = eliminate(system, self._maps, self._delassus_definite)
        if elimination is None:
            return self._solve_with_forces(modes, system)
        return self._solve_reduced(modes, system, elimination, limit)

    def forces_at(self, modes: tuple[int, ...], controls: FloatArray) -> FloatArray | None:
        """Scaled forces (3K,) of these modes at scaled controls; None where not determined."""
        found = eliminate(self._maps.system(modes), self._maps, self._delassus_definite)
        return None if found is None else found.forces[:, 0] + found.forces[:, 1:] @ controls

    def points_at(self, controls: FloatArray, force: FloatArray) -> FloatArray:
        """Scaled (f, w) of every contact, (K, 6), at scaled controls and forces."""
        velocity = (
            self.free_velocity[:, 0] + self.free_velocity[:, 1:] @ controls + self.delassus @ force
        )
        return np.concatenate([force.reshape(-1, 3), velocity.reshape(-1, 3)], axis=1)

    def unscale(self, controls: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Controls, inside their bounds, and forces (K, 3) in the problem's units."""
        own = self.problem
        u = np.minimum(np.maximum(controls * self.control_scale, own.lower), own.upper)
        return u, points[:, :3] * self.impulse

    def _solve_reduced(
        self,
        modes: tuple[int, ...],
        system: ModeSystem,
        elimination: ForceElimination,
        limit: float,
    ) -> ModeMinimiser | None:
        """The QP over the controls, forces eliminated."""
        objective = self.objective.reduced(elimination)
        cutoff = math.inf if limit == math.inf else self._cutoff(objective, limit)
        if cutoff < 0.0:
            return None
        rows = system.inequality_map(elimination.points)
        program = QPProblem(
            P=objective.P,
            c=objective.c,
            A=self._no_rows,
            b=self._no_values,
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
        return self._minimiser(modes, ReducedQP(system, elimination, program, solution))

    def _cutoff(self, objective: ReducedObjective, limit: float) -> float:
        """The limit as the cutoff of a QP: scaled, and measured from the unconstrained minimum."""
        minimum = objective.unconstrained_minimum
        if minimum is None:
            return math.inf
        return (limit - self.problem.constant) / self.value_scale - minimum

    def polish(self, minimiser: ModeMinimiser) -> ModeMinimiser:
        """The minimiser accurate to rounding, where its active set is clear."""
        reduced_qp = minimiser.reduced_qp
        if reduced_qp is None:
            return minimiser
        solution = polish(reduced_qp.program, reduced_qp.solution)
        if solution is reduced_qp.solution:
            return minimiser
        return self._minimiser(minimiser.modes, replace(reduced_qp, solution=solution))

    def _minimiser(self, modes: tuple[int, ...], reduced_qp: ReducedQP) -> ModeMinimiser:
        solution, affine = reduced_qp.solution, reduced_qp.elimination.points
        points = (affine[:, 0] + affine[:, 1:] @ solution.x).reshape(-1, 6)
        value, gradient = self._value(solution.x, points)
        return ModeMinimiser(
            modes=modes,
            controls=solution.x,
            points=points,
            compute_multipliers=partial(self._multipliers, reduced_qp, gradient),
            value=value,
            stationarity=solution.dual_residual,
            reduced_qp=reduced_qp,
        )

    def _multipliers(self, reduced_qp: ReducedQP, gradient: FloatArray) -> FloatArray:
        """Multipliers (K, 6) of the contacts from those of the inequalities of a reduced QP."""
        system, width = reduced_qp.system, self.free_velocity.shape[1]
        rows = reduced_qp.solution.multipliers.rows
        on_force, on_velocity = system.inequality_multipliers(rows)
        left = gradient - on_velocity @ self.delassus
        amplitudes = system.force_basis @ (left - on_force)
        constraints = reduced_qp.elimination.constraint_multipliers(amplitudes)
        back = (constraints @ system.velocity_constraints[:, width:]).reshape(2, -1)
        return per_contact(left - back[0], on_velocity + back[1])

    def _solve_with_forces(
        self, modes: tuple[int, ...], system: ModeSystem
    ) -> ModeMinimiser | None:
        """The QP over controls and force amplitudes, for singular T Wf E."""
        nu, k = len(self.lower), len(self.delassus)
        if is_inconsistent(system, k, self.lower, self.upper):
            return None
        count = len(system.force_basis)
        to_forces = np.zeros((nu + k, nu + count))
        to_forces[:nu, :nu] = np.eye(nu)
        to_forces[nu:, nu:] = system.force_basis.T
        constraints = system.velocity_constraints
        by_amplitude = constraints[:, 1 + nu : 1 + nu + k] @ system.force_basis.T
        points_map = [self._maps.base[k : 3 * k], system.force_response[:, k : 3 * k].T]
        rows = system.inequality_map(np.concatenate(points_map, axis=1))
        free = np.full(count, np.inf)
        self.qp_count += 1
        solution = self.qp_solver.solve(
            QPProblem(
                P=to_forces.T @ self.objective.matrix() @ to_forces,
                c=to_forces.T @ self.objective.c,
                A=np.concatenate([constraints[:, 1 : 1 + nu], by_amplitude], axis=1),
                b=-constraints[:, 0],
                G=rows[:, 1:],
                h=-rows[:, 0],
                lower=np.concatenate([self.lower, -free]),
                upper=np.concatenate([self.upper, free]),
            )
        )
        if solution.status is not QPStatus.SOLVED or solution.primal_residual > CONSISTENT:
            return None
        controls, force = solution.x[:nu], system.force_basis.T @ solution.x[nu:]
        points = self.points_at(controls, force)
        value, gradient = self._value(controls, points)
        on_velocity = solution.multipliers.equalities @ constraints[:, 1 + nu + k :]
        on_velocity = on_velocity + system.inequality_multipliers(solution.multipliers.rows)[1]
        multipliers = per_contact(gradient - on_velocity @ self.delassus, on_velocity)
        return ModeMinimiser(
            modes=modes,
            controls=controls,
            points=points,
            compute_multipliers=lambda: multipliers,
            value=value,
            stationarity=solution.dual_residual,
        )

    def _value(self, controls: FloatArray, points: FloatArray) -> tuple[float, FloatArray]:
        """The objective in the problem's unit, and its scaled gradient in the forces, (3K,)."""
        z = np.concatenate([controls, points[:, :3].reshape(-1)])
        product, c = self.objective.times(z), self.objective.c
        value = 0.5 * float(z @ product) + float(z @ c)
        value = value * self.value_scale + self.problem.constant
        return value, (product + c)[len(controls) :]


def per_contact(on_force: FloatArray, on_velocity: FloatArray) -> FloatArray:
    """(K, 6) from (3K,) of all forces and (3K,) of all velocities."""
    return np.concatenate([on_force.reshape(-1, 3), on_velocity.reshape(-1, 3)], axis=1)
