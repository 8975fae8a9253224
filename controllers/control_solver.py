"""From goals to activations: builds the step's QPCC on the reduced dynamics and solves it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.body.directional_friction import DIRECTIONS
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.compiled.contact_solver import CompiledSearch
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.controller import ActivationCost, Controller, Goals
from warp_softbody.controllers.patches import Patch
from warp_softbody.controllers.perturbation_schedule import PerturbationSchedule
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT, STICK
from warp_softbody.controllers.qpcc.contact.problem import (
    ContactQPCC,
    step_problem,
    uniform_directions,
)
from warp_softbody.controllers.qpcc.result import QPCCResult, SolverOptions
from warp_softbody.controllers.qpcc.solve import solve_qpcc, solve_static
from warp_softbody.engine.reduced_dynamics import ControlProblem, ReducedDynamics
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.world.frame import ContactSample
from warp_softbody.world.view import BodyView

SHORTEST = 0.5
"""Smallest activation l_d / l_0 (docs/method.md section 2)."""


@dataclass(frozen=True, kw_only=True)
class Decision:
    """What the control solver chose for a step.

    Attributes:
        rest_lengths: l_d, (s,) m.
        problem: the QPCC that was solved.
        result: of the QPCC.
        converged: whether the reduced dynamics reached their tolerance and the QPCC's point is
            usable; where it is not, the activations stay as they were.
        kicked: whether the QPCC's solve was free to look for other modes by kicks.
        view: what the controller saw.
        goals: what it wanted, with the contacts that the plan could use.
        time_unit: of the body, s.
    """

    rest_lengths: FloatArray
    problem: ContactQPCC
    result: QPCCResult
    converged: bool
    kicked: bool
    view: BodyView
    goals: Goals
    time_unit: float

    @property
    def patches(self) -> tuple[Patch, ...]:
        """The contacts that the plan could use."""
        return self.goals.patches

    @cached_property
    def planned(self) -> ContactSample:
        """The patches with the modes and forces that the plan has for them.

        In place of nodes stand their numbers. Only a frame that is handed out asks for it.
        """
        return _planned(self.view, self.patches, self.result)


def activation_bounds(problem: ControlProblem) -> tuple[FloatArray, FloatArray]:
    """Bounds of a = l_d / l_0: 0.5 to 1, never beyond what a segment reaches in the step."""
    reach = problem.reaches / problem.rest_lengths
    return np.minimum(SHORTEST, reach), np.minimum(1.0, reach)


def build_qpcc(
    goals: Goals,
    problem: ControlProblem,
    activations: FloatArray,
    time_step: float,
    *,
    time_unit: float,
    cone: int = DIRECTIONS,
) -> ContactQPCC:
    """The step's QPCC over activations and patch impulses; J = [objectives; patches].

    ``time_unit`` is that of the body, s (`BodyUnits`), in which a change of activations is weighed.
    ``cone`` is the number of directions of the friction cones, of which `DIRECTIONS` is a multiple;
    patches know their friction along `DIRECTIONS` of them.
    """
    stride = DIRECTIONS // cone
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
        friction=np.array([0.0 if patch.slips else patch.friction for patch in goals.patches]),
        factors=np.array([patch.factors[::stride] for patch in goals.patches]),
        directions=uniform_directions(cone),
        squares=squares,
    )


def _activation_weights(cost: ActivationCost, count: int, step: float) -> tuple[float, float]:
    """Second derivatives of the two terms for each segment, in a step of so many time units."""
    return 2.0 * cost.effort / count, 2.0 * cost.change / (step * count)


class _Search(Protocol):
    """``solve_qpcc``, or native code that does the same."""

    def __call__(
        self,
        problem: ContactQPCC,
        *,
        start: tuple[int, ...] | None,
        fallback_controls: FloatArray,
        touching: BoolArray,
        options: SolverOptions,
    ) -> QPCCResult:
        """The best point found."""


class ControlSolver:
    """Asks a controller for goals each step and finds the activations that serve them best.

    In a step of its own loop a user asks for `goals` of a view, and hands those to `decide` once
    the step's matrix is assembled (`Stepper.step`).
    """

    def __init__(
        self,
        controller: Controller,
        dynamics: ReducedDynamics,
        options: ControlOptions | None = None,
    ) -> None:
        """Solve by the QPCC or by the static-contact baseline, as the options say."""
        # made anew, so that one that went round its constructor is checked too
        options = replace(checks.optional("options of a ControlSolver", options, ControlOptions))
        self._controller = controller
        self._dynamics = dynamics
        self._method = options.method
        self._cone = options.planned_cone
        self._modes: tuple[int, ...] | None = None
        self._parts: tuple[int | None, ...] = ()
        self._rule = PerturbationSchedule(options)
        self._search: _Search = CompiledSearch().solve if dynamics.native_code else solve_qpcc

    def goals(self, view: BodyView) -> Goals | None:
        """What the controller wants of the step from ``view`` on; to be asked once a step."""
        goals = self._controller.goals(view)
        if goals is None:
            self._modes = None
        elif not isinstance(goals, Goals):
            asked = f"what {type(self._controller).__name__}.goals(view) returns"
            checks.refuse(asked, "Goals or None", goals)
        return goals

    def decide(self, view: BodyView, goals: Goals) -> Decision:
        """Rest lengths that serve goals best; the step's matrix has to be assembled."""
        if self._method == "static":
            goals = replace(goals, patches=tuple(replace(p, slips=False) for p in goals.patches))
        # before the first step nobody knows what touches
        free = view.time > 0.0 and not goals.patches and not view.touching.any()
        problem = self._dynamics.solve(_rows_of(goals, view), free=free)
        _check_maps(goals, problem)
        activations = np.minimum(view.activations, problem.reaches / problem.rest_lengths)
        time_unit = BodyUnits.of(view).time
        qpcc = build_qpcc(
            goals,
            problem,
            activations,
            view.time_step,
            time_unit=time_unit,
            cone=self._cone,
        )
        start = self._start(goals.patches)
        result = self._solve(qpcc, activations, goals.patches, start)
        usable = result.status.usable
        left_out = self._rule.note(start, result, usable)
        self._modes = result.modes if usable else None
        self._parts = tuple(patch.part for patch in goals.patches)
        chosen = result.controls if usable else activations
        return Decision(
            rest_lengths=chosen * problem.rest_lengths,
            problem=qpcc,
            result=result,
            converged=problem.converged and usable,
            kicked=self._method == "qpcc" and not left_out,
            view=view,
            goals=goals,
            time_unit=time_unit,
        )

    def _solve(
        self,
        qpcc: ContactQPCC,
        activations: FloatArray,
        patches: tuple[Patch, ...],
        start: tuple[int, ...] | None,
    ) -> QPCCResult:
        holds = np.array([patch.touching for patch in patches], dtype=bool)
        if self._method == "static":
            return solve_static(
                qpcc, touching=holds, fallback_controls=activations, options=self._rule.kicked
            )
        return self._search(
            qpcc,
            start=start,
            fallback_controls=activations,
            touching=holds,
            options=self._rule.options(),
        )

    def _start(self, patches: tuple[Patch, ...]) -> tuple[int, ...] | None:
        """The last modes: of the same parts, or of as many patches where these have none."""
        parts = tuple(patch.part for patch in patches)
        if self._modes is None or parts == self._parts:
            return self._modes
        if None in parts or None in self._parts:
            return self._modes if len(self._modes) == len(patches) else None
        known = dict(zip(self._parts, self._modes, strict=True))
        return tuple(known.get(patch.part, STICK if patch.touching else LIFT) for patch in patches)


def _rows_of(goals: Goals, view: BodyView) -> FloatArray:
    """All rows (r, 3n) of what is wanted; refused where they are not of this body."""
    count = view.node_count
    for objective in goals.objectives:
        if objective.rows.shape[1] != 3 * count:
            raise InputError(
                f"objective {objective.name!r}: rows must have {3 * count} columns, three a node, "
                f"not {objective.rows.shape[1]}"
            )
    for number, patch in enumerate(goals.patches):
        if len(patch.weights) != count:
            raise InputError(
                f"patch {number}: weights must be {count}, one a node, not {len(patch.weights)}"
            )
    if goals.resting and max(goals.resting) >= len(view.activations):
        raise InputError(
            f"Goals.resting holds segment {max(goals.resting)}, but there are "
            f"{len(view.activations)} segments"
        )
    wanted = [objective.rows for objective in goals.objectives]
    begin = sum(map(len, wanted))
    every = np.empty((begin + 3 * len(goals.patches), 3 * count))
    if wanted:
        np.concatenate(wanted, out=every[:begin])
    by_node = every[begin:].reshape(-1, 3, count, 3)
    for patch, rows in zip(goals.patches, by_node, strict=True):
        np.multiply(patch.frame[:, None, :], patch.weights[:, None], out=rows)
    _refuse_infinite(goals, every, "rows")
    return every


def _check_maps(goals: Goals, problem: ControlProblem) -> None:
    """Refuse what an objective's size has made infinite on the way through the engine."""
    answers = [problem.compliance, problem.free_velocity[:, None], problem.muscle_map]
    _refuse_infinite(goals, np.concatenate(answers, axis=1), "responses of the body")


def _refuse_infinite(goals: Goals, by_row: FloatArray, what: str) -> None:
    if math.isfinite(np.add.reduce(by_row, axis=None)):
        return
    wrong = np.flatnonzero(~np.isfinite(by_row).all(axis=1))
    if not wrong.size:
        return
    names = [f"objective {o.name!r}" for o in goals.objectives for _ in range(len(o.rows))]
    names += [f"patch {number}" for number in range(len(goals.patches)) for _ in range(3)]
    raise InputError(f"{names[wrong[0]]}: {what} are not finite")


def _planned(view: BodyView, patches: tuple[Patch, ...], result: QPCCResult) -> ContactSample:
    """Mean points of the patches, and what the plan has for them."""
    if not patches or len(result.modes) != len(patches):
        return ContactSample()
    weights = np.array([patch.weights for patch in patches])
    frames = np.array([patch.frame for patch in patches])
    forces = np.einsum("kij,ki->kj", frames, result.forces) / view.time_step
    return ContactSample(
        nodes=np.arange(len(patches), dtype=np.int32),
        points=weights @ view.positions,
        modes=np.array(result.contact_modes, dtype=np.int32),
        forces=forces,
    )
