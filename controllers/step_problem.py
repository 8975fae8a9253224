"""The contact problem of a step: made in NumPy, and what native code makes the same one from."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.directional_friction import DIRECTIONS
from warp_softbody.controllers.compiled.contact_solver import StepTerms
from warp_softbody.controllers.controller import ActivationCost, Goals
from warp_softbody.controllers.patches import Patch
from warp_softbody.controllers.qpcc.contact.problem import (
    MOST_FRICTION,
    ContactQPCC,
    step_problem,
    uniform_directions,
)
from warp_softbody.engine.reduced_dynamics import Maps
from warp_softbody.errors import InputError
from warp_softbody.world.view import BodyView

SHORTEST = 0.5
"""Smallest activation l_d / l_0 (docs/method.md section 2)."""


def present_activations(view: BodyView, maps: Maps) -> FloatArray:
    """The activations (s,) that the step begins with, none beyond what a segment reaches."""
    return np.minimum(view.activations, maps.reaches / maps.rest_lengths)


def activation_bounds(problem: Maps) -> tuple[FloatArray, FloatArray]:
    """Bounds of a = l_d / l_0: 0.5 to 1, never beyond what a segment reaches in the step."""
    reach = problem.reaches / problem.rest_lengths
    return np.minimum(SHORTEST, reach), np.minimum(1.0, reach)


def build_qpcc(
    goals: Goals,
    problem: Maps,
    activations: FloatArray,
    time_step: float,
    *,
    time_unit: float,
    cone: int = DIRECTIONS,
) -> ContactQPCC:
    """The step's QPCC over activations and patch impulses; J = [objectives; patches].

    Native code does the same (`step_terms`, ``kernels.control.step_assembly``).

    ``time_unit`` is that of the body, s (`BodyUnits`), in which a change of activations is weighed.
    ``cone`` is the number of directions of the friction cones, of which `DIRECTIONS` is a multiple;
    patches know their friction along `DIRECTIONS` of them.
    """
    stride = DIRECTIONS // cone
    activations = _counted_from(goals, activations)
    wanted = sum(len(objective.rows) for objective in goals.objectives)
    scale = problem.rest_lengths
    by_activation = problem.muscle_map * scale
    offset = problem.free_velocity - problem.muscle_map @ problem.lengths
    maps = np.concatenate([by_activation[:wanted], problem.compliance[:wanted, wanted:]], axis=1)
    target = np.concatenate([o.target for o in goals.objectives] or [np.zeros(0)])
    weight = np.concatenate([o.weight for o in goals.objectives] or [np.zeros(0)])
    miss = offset[:wanted] - target
    root = np.sqrt(2.0 * weight)
    squares = root[:, None] * maps
    hessian = squares.T @ squares
    gradient = (root * miss) @ squares
    effort, change = _activation_weights(goals.activation, len(scale), time_step / time_unit)
    diagonal = np.arange(len(scale))
    hessian[diagonal, diagonal] += effort + change
    gradient[: len(scale)] -= effort + change * activations
    constant = float(weight @ (miss * miss)) + 0.5 * float(
        effort * len(scale) + change * (activations @ activations)
    )
    gaps = np.zeros(3 * len(goals.patches))
    gaps[::3] = [patch.gap / time_step for patch in goals.patches]
    lower, upper = activation_bounds(problem)
    resting = list(goals.resting)
    lower[resting] = upper[resting]
    return step_problem(
        hessian=hessian,
        gradient=gradient,
        constant=constant,
        lower=lower,
        upper=upper,
        velocity_offset=offset[wanted:] + gaps,
        velocity_from_controls=by_activation[wanted:],
        velocity_from_forces=problem.compliance[wanted:, wanted:],
        friction=_planned_friction(goals.patches),
        factors=np.array([patch.factors[::stride] for patch in goals.patches]),
        directions=uniform_directions(cone),
        squares=squares,
    )


@lru_cache(maxsize=8)
def planned_directions(cone: int) -> FloatArray:
    """The directions (cone, 2) of the friction cones that steps are planned with, read-only."""
    directions = uniform_directions(cone)
    directions.setflags(write=False)
    return directions


def step_terms(
    goals: Goals,
    maps: Maps,
    activations: FloatArray,
    time_step: float,
    *,
    time_unit: float,
    cone: int = DIRECTIONS,
) -> StepTerms:
    """What native code makes the QPCC of `build_qpcc` from, for the same arguments."""
    objectives, patches, stride = goals.objectives, goals.patches, DIRECTIONS // cone
    joined = np.concatenate
    return StepTerms(
        muscle_map=maps.muscle_map,
        compliance=maps.compliance,
        step_velocity=maps.free_velocity,
        lengths=maps.lengths,
        reaches=maps.reaches,
        rest_lengths=maps.rest_lengths,
        activations=_counted_from(goals, activations),
        targets=joined([o.target for o in objectives]) if objectives else np.zeros(0),
        goal_weights=joined([o.weight for o in objectives]) if objectives else np.zeros(0),
        gaps=np.array([patch.gap for patch in patches]) / time_step,
        costs=_activation_weights(goals.activation, len(activations), time_step / time_unit),
        friction=_planned_friction(patches),
        factors=np.array([patch.factors for patch in patches]).reshape(-1, DIRECTIONS)[:, ::stride],
        directions=planned_directions(cone),
        resting=goals.resting,
    )


def _counted_from(goals: Goals, activations: FloatArray) -> FloatArray:
    """The activations (s,) from which a change costs something.

    Raises:
        InputError: those of the goals are not one a segment.
    """
    if not goals.nominal:
        return activations
    if len(goals.nominal) != len(activations):
        raise InputError(
            f"Goals.nominal must have {len(activations)} activations, one for each segment, "
            f"not {len(goals.nominal)}"
        )
    return np.array(goals.nominal)


def _activation_weights(cost: ActivationCost, count: int, step: float) -> tuple[float, float]:
    """Second derivatives of the two terms for each segment, in a step of so many time units."""
    return 2.0 * cost.effort / count, 2.0 * cost.change / (step * count)


def _planned_friction(patches: Sequence[Patch]) -> FloatArray:
    """(K,), as large as a QPCC takes it, and none where a patch is to slip."""
    own = [0.0 if patch.slips else min(patch.friction, MOST_FRICTION) for patch in patches]
    return np.array(own)
