"""Contact problems that tests of the control problem share, and a reference for small ones."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np

from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qp.problem import QPProblem, QPStatus
from warp_softbody.controllers.qpcc import ContactQPCC, to_full, uniform_directions

MASS = 2.0
WEIGHT_IMPULSE = MASS * 9.81 * 0.01
"""N s in one step of 0.01 s."""


def block(
    push: tuple[float, float, float], *, friction: float = 0.5, wanted: float = 0.0, **changes: Any
) -> ContactQPCC:
    """A point mass on the ground; push is an impulse (N s), the one control pushes along t1."""
    values: dict[str, Any] = {
        "hessian": np.diag([1.0, 0.0, 0.0, 0.0]),
        "gradient": np.array([-wanted, 0.0, 0.0, 0.0]),
        "lower": np.array([-np.inf]),
        "upper": np.array([np.inf]),
        "velocity_offset": (np.array(push) - [WEIGHT_IMPULSE, 0.0, 0.0]) / MASS,
        "velocity_from_controls": np.array([[0.0], [1.0], [0.0]]) / MASS,
        "velocity_from_forces": np.eye(3) / MASS,
        "friction": friction,
    }
    return ContactQPCC(**(values | changes))


def soft_body(seed: int, *, contacts: int, controls: int, directions: int = 8) -> ContactQPCC:
    """Contacts on a random soft body of 30 more unknowns; eight momentum-like rows to be met."""
    rng = np.random.default_rng(seed)
    size, k = 3 * contacts + 30, 3 * contacts
    factor = rng.normal(size=(size, size))
    mobility = factor @ factor.T / size + 0.05 * np.eye(size)
    muscles = 0.6 * rng.normal(size=(size, controls))
    velocity = 0.5 * rng.normal(size=size)
    velocity[0:k:3] -= 0.8 * rng.random(contacts)
    rows = rng.normal(size=(8, size))
    slopes = np.hstack([rows @ mobility @ muscles, rows @ mobility[:, :k]])
    error = rows @ velocity + 0.5 * rng.normal(size=8)
    effort = np.diag(np.r_[np.full(controls, 1e-2), np.zeros(k)])
    return ContactQPCC(
        hessian=slopes.T @ slopes + effort,
        gradient=slopes.T @ error,
        constant=0.5 * float(error @ error),
        lower=np.full(controls, -0.5),
        upper=np.full(controls, 0.5),
        velocity_offset=velocity[:k],
        velocity_from_controls=(mobility @ muscles)[:k],
        velocity_from_forces=mobility[:k, :k],
        friction=np.full(contacts, 0.7),
        directions=uniform_directions(directions),
    )


def repeated(problem: ContactQPCC, contacts: list[int]) -> ContactQPCC:
    """The problem with contacts listed again, so that Wf has no full rank."""
    nu = problem.control_count
    rows = np.concatenate([3 * i + np.arange(3) for i in contacts])
    z = np.r_[np.arange(nu), nu + rows]
    return replace(
        problem,
        hessian=problem.hessian[np.ix_(z, z)],
        gradient=problem.gradient[z],
        velocity_offset=problem.velocity_offset[rows],
        velocity_from_controls=problem.velocity_from_controls[rows],
        velocity_from_forces=problem.velocity_from_forces[np.ix_(rows, rows)],
        friction=problem.friction[contacts],
        factors=problem.factors[contacts],
        squares=problem.squares[:, z] if problem.squares.size else problem.squares,
    )


def enumerate_pairs(problem: ContactQPCC) -> float:
    """Least objective over all 2^pairs choices of a zero side in the full form, without pieces."""
    full, best = to_full(problem), np.inf
    qp_solver = PIQPSolver()
    left, right = np.c_[full.L, full.l0], np.c_[full.R, full.r0]
    for choice in itertools.product((False, True), repeat=len(full.l0)):
        side = np.array(choice)
        zero, positive = left.copy(), right.copy()
        zero[side], positive[side] = right[side], left[side]
        solution = qp_solver.solve(
            QPProblem(
                P=full.Q,
                c=full.c,
                A=zero[:, :-1],
                b=-zero[:, -1],
                G=positive[:, :-1],
                h=-positive[:, -1],
                lower=full.lb,
                upper=full.ub,
            )
        )
        if solution.status is QPStatus.SOLVED:
            best = min(best, solution.value + full.c0)
    return best
