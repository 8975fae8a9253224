"""What a step came to, beside what its plan expected of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from warp_softbody.arrays import FloatArray, cross_rows
from warp_softbody.controllers.body_units import LEAST_GRAVITY, BodyUnits
from warp_softbody.world.scene import STANDARD_GRAVITY

if TYPE_CHECKING:
    from warp_softbody.controllers.control_solver import Decision
    from warp_softbody.world.view import BodyView

SMALL = 1e-3
"""Costs below this, a missing force of 3 % of the weight, count as it in shares of a cost."""


@dataclass(frozen=True, kw_only=True)
class PlanOutcome:
    """Of one planned step; a plan bears on patches, the step on all nodes that touch.

    Attributes:
        time: at which the step began, s.
        momentum_planned, momentum: at the end of the step, (3,) N s.
        spin_planned, spin: angular momentum about the centre of mass then, (3,) N m s.
        share_planned, share: of the body's weight that contact bears in the step.
        momentum_miss: |planned less realised momentum| over m g dt, which is how far the impulse of
            contact is from the planned one. All of these are NaN where nodes of the scene are held.
        feet_miss: largest |velocity of a patch, planned less realised| over sqrt(g L).
        planned, reached: the cost, of the goals and of the activations.
    """

    time: float
    momentum_planned: FloatArray
    momentum: FloatArray
    spin_planned: FloatArray
    spin: FloatArray
    share_planned: float
    share: float
    momentum_miss: float
    feet_miss: float
    planned: float
    reached: float

    @property
    def cost_miss(self) -> float:
        """|planned less reached cost| over the larger one."""
        return cost_miss(self.planned, self.reached)


def cost_miss(planned: float, reached: float) -> float:
    """|planned less reached cost| over the larger one, which counts as `SMALL` at least."""
    return abs(planned - reached) / max(abs(planned), abs(reached), SMALL)


def plan_outcome(decision: Decision, velocities: FloatArray, pushes: FloatArray) -> PlanOutcome:
    """Of a decision, the velocities (n, 3) m/s that it led to and outer forces (n, 3) N.

    Costs and feet of a plan that looks further ahead are those at its horizon, if the body goes on
    as in the step.
    """
    view = decision.view
    planned_rows = planned_values(decision)
    planned, reached, feet = _goals(decision, planned_rows, velocities)
    expected, turned = _planned_impulses(decision)
    momentum = view.masses @ velocities
    spin = view.turning @ velocities.ravel()
    # what contact gave: all that neither weight, outer forces nor damping explain
    known, known_spin = _known_impulses(view, momentum, spin, pushes)
    given = momentum - view.linear_momentum - known
    given_spin = spin - view.angular_momentum - known_spin
    gravity = np.asarray(view.scene.gravity)
    size = view.gravity if view.gravity > LEAST_GRAVITY else STANDARD_GRAVITY
    unit = view.mass * size * view.time_step
    up = -gravity / size / unit
    return PlanOutcome(
        time=view.time,
        momentum_planned=momentum - given + expected,
        momentum=momentum,
        spin_planned=spin - given_spin + turned,
        spin=spin,
        share_planned=float(up @ expected),
        share=float(up @ given),
        momentum_miss=float(np.linalg.norm(given - expected)) / unit,
        feet_miss=feet / BodyUnits.of(view).speed,
        planned=decision.result.objective,
        # the activations are those of the plan
        reached=reached + decision.result.objective - planned,
    )


def planned_values(decision: Decision) -> FloatArray:
    """(q + 3K,) what a plan expects of the rows of all goals, and of its patches' velocities."""
    maps, impulses = decision.maps, np.asarray(decision.result.forces).ravel()
    chosen = decision.lengths_ahead - maps.lengths
    values = maps.free_velocity + maps.muscle_map @ chosen
    if len(impulses):
        values = values + maps.compliance[:, len(values) - len(impulses) :] @ impulses
    return np.asarray(values)


def _goals(
    decision: Decision, planned_rows: FloatArray, velocities: FloatArray
) -> tuple[float, float, float]:
    """Cost of the goals, planned and reached, and the largest miss of a patch's velocity, m/s."""
    goals, view = decision.goals, decision.view
    soon = view.at_horizon(view.velocities, velocities)
    planned = reached = 0.0
    begin = 0
    for objective in goals.objectives:
        end = begin + len(objective.rows)
        missed = planned_rows[begin:end] - objective.target
        planned += float(objective.weight @ (missed * missed))
        missed = objective.rows @ soon.ravel() - objective.target
        reached += float(objective.weight @ (missed * missed))
        begin = end
    if not len(decision.result.forces):
        return planned, reached, 0.0
    off = [
        planned_rows[begin + 3 * number : begin + 3 * number + 3]
        - patch.frame @ (patch.weights @ soon)
        for number, patch in enumerate(goals.patches)
    ]
    return planned, reached, max(float(np.linalg.norm(one)) for one in off)


def _planned_impulses(decision: Decision) -> tuple[FloatArray, FloatArray]:
    """Impulse (3,) N s, and angular impulse N m s, that the plan has for the step's contacts."""
    view, forces = decision.view, np.asarray(decision.result.forces).reshape(-1, 3)
    impulse, turn = np.zeros(3), np.zeros(3)
    for patch, along in zip(decision.goals.patches if len(forces) else (), forces, strict=True):
        own = along @ patch.frame / view.steps_ahead
        impulse += own
        turn += np.cross(patch.weights @ view.positions - view.center_of_mass, own)
    return impulse, turn


def _known_impulses(
    view: BodyView, momentum: FloatArray, spin: FloatArray, pushes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What weight, outer forces (n, 3) N and mass damping give in a step.

    NaN where handles or fixed nodes give something too.
    """
    held = view.scene.held
    if view.masses[held[held < view.node_count]].any():
        return np.full(3, np.nan), np.full(3, np.nan)
    step = view.time_step
    damping = step * view.scene.character.material.mass_damping
    known = step * view.mass * np.asarray(view.scene.gravity) - damping * momentum
    turn = -damping * spin
    if pushes.any():
        pushes = np.where(view.masses[:, None] > 0.0, pushes, 0.0)
        known = known + step * pushes.sum(axis=0)
        arms = view.positions - view.center_of_mass
        turn = turn + step * cross_rows(arms, pushes).sum(axis=0)
    return known, turn
