"""From goals to activations: builds the step's QPCC on the reduced dynamics and solves it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.compiled.contact_solver import (
    CompiledSearch,
    SearchBegin,
    SearchRooms,
)
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.controller import Controller, Goals
from warp_softbody.controllers.goal_rows import check_maps, check_sizes, rows_of
from warp_softbody.controllers.patches import Patch
from warp_softbody.controllers.perturbation_schedule import PerturbationSchedule
from warp_softbody.controllers.qpcc.contact.mode_table import LIFT, STICK
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.result import QPCCResult, SolverOptions
from warp_softbody.controllers.qpcc.solve import solve_qpcc, solve_static
from warp_softbody.controllers.step_problem import build_qpcc, present_activations, step_terms
from warp_softbody.engine.reduced_dynamics import Maps, ReducedDynamics
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.frame import ContactSample
from warp_softbody.world.view import BodyView


@dataclass(frozen=True, kw_only=True)
class Decision:
    """What the control solver chose for a step.

    Attributes:
        rest_lengths: l_d, (s,) m: as much of the way to those of the plan as the step is of the
            time that the plan looks ahead.
        maps: the step's linear maps that it was chosen by.
        cone: directions of the friction cones.
        result: of the QPCC.
        converged: whether the reduced dynamics reached their tolerance and the QPCC's point is
            usable; where it is not, the activations stay as they were.
        kicked: whether the QPCC's solve was free to look for other modes by kicks.
        view: what the controller saw.
        goals: what it wanted, with the contacts that the plan could use.
        time_unit: of the body, s.
    """

    rest_lengths: FloatArray
    maps: Maps
    cone: int
    result: QPCCResult
    converged: bool
    kicked: bool
    view: BodyView
    goals: Goals
    time_unit: float

    @cached_property
    def problem(self) -> ContactQPCC:
        """The QPCC that was solved, made anew: native code solves it without making it."""
        return build_qpcc(
            self.goals,
            self.maps,
            present_activations(self.view, self.maps),
            self.view.horizon,
            time_unit=self.time_unit,
            cone=self.cone,
        )

    @property
    def lengths_ahead(self) -> FloatArray:
        """Rest lengths (s,) m at the end of the plan's horizon; of one step the chosen ones."""
        if not self.result.status.usable:
            return self.rest_lengths
        return np.asarray(self.result.controls * self.maps.rest_lengths)

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


@dataclass(frozen=True, eq=False)
class SolverMemory:
    """What a `ControlSolver` remembers from step to step.

    Attributes:
        minima: modes of the last minima, the best one first.
        parts: of the patches that they belong to.
        schedule: of kicks, as in `PerturbationSchedule.memory`.
        search: where native solves begin, as in `CompiledSearch.memory`.
    """

    minima: tuple[tuple[int, ...], ...]
    parts: tuple[int | None, ...]
    schedule: tuple[bool, int]
    search: tuple[SearchBegin, ...]


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
        self._controller: Controller = input_kinds.controller(
            "controller of a ControlSolver", controller
        )
        self._dynamics = dynamics
        self._method = options.method
        self._cone = options.planned_cone
        self._carried = options.carried
        self._minima: tuple[tuple[int, ...], ...] = ()
        self._parts: tuple[int | None, ...] = ()
        self._rule = PerturbationSchedule(options)
        self._compiled: CompiledSearch | None = None
        if dynamics.native_code:
            rooms = dynamics.workspace.shared("contact searches", (), (), SearchRooms)
            self._compiled = CompiledSearch(rooms)

    @property
    def memory(self) -> SolverMemory:
        """What is remembered between two steps, beside what the controller itself remembers."""
        search = () if self._compiled is None else self._compiled.memory
        return SolverMemory(self._minima, self._parts, self._rule.memory, search)

    @memory.setter
    def memory(self, memory: SolverMemory) -> None:
        self._minima, self._parts = memory.minima, memory.parts
        self._rule.memory = memory.schedule
        if self._compiled is not None:
            self._compiled.memory = memory.search

    def goals(self, view: BodyView) -> Goals | None:
        """What the controller wants of the step from ``view`` on; to be asked once a step."""
        goals = self._controller.goals(view)
        if goals is None:
            self._minima = ()
        elif not isinstance(goals, Goals):
            asked = f"what {type(self._controller).__name__}.goals(view) returns"
            checks.refuse(asked, "Goals or None", goals)
        return goals

    def decide(self, view: BodyView, goals: Goals) -> Decision:
        """Rest lengths that serve goals best; the step's matrix has to be assembled."""
        if self._method == "static":
            goals = replace(goals, patches=tuple(replace(p, slips=False) for p in goals.patches))
        maps = self._maps(goals, view)
        activations = present_activations(view, maps)
        time_unit = BodyUnits.of(view).time
        starts = self._starts(goals.patches)
        start = starts[0] if starts else None
        asked = (goals, maps, activations, view.horizon, time_unit, starts)
        result = self._solve(*asked, self._rule.options())
        with_kicks = self._rule.retry(result) if self._method == "qpcc" else None
        if with_kicks is not None:
            spent = result.qp_count
            result = self._solve(*asked, with_kicks)
            result = unchecked_copy(result, qp_count=result.qp_count + spent)
        usable = result.status.usable
        left_out = self._rule.note(start, result, usable)
        self._minima = (result.modes, *result.others[: self._carried]) if usable else ()
        self._parts = tuple(patch.part for patch in goals.patches)
        chosen = result.controls if usable else activations
        if view.steps_ahead > 1:
            # the plan's activations are those at the end of its horizon
            chosen = activations + (chosen - activations) / view.steps_ahead
        return Decision(
            rest_lengths=chosen * maps.rest_lengths,
            maps=maps,
            cone=self._cone,
            result=result,
            converged=maps.converged and usable,
            kicked=self._method == "qpcc" and not left_out,
            view=view,
            goals=goals,
            time_unit=time_unit,
        )

    def _maps(self, goals: Goals, view: BodyView) -> Maps:
        """The step's linear maps of all that is wanted, by native code where that serves."""
        check_sizes(goals, view)
        # before the first step nobody knows what touches
        free = view.time > 0.0 and not goals.patches and not view.touching.any()
        if not free:
            found = self._dynamics.fast_maps(
                [objective.rows for objective in goals.objectives],
                [patch.weights for patch in goals.patches],
                [patch.frame for patch in goals.patches],
            )
            if found is not None:
                return found
        maps = self._dynamics.solve(rows_of(goals, view), free=free)
        check_maps(goals, maps)
        return maps

    def _solve(
        self,
        goals: Goals,
        maps: Maps,
        activations: FloatArray,
        time_step: float,
        time_unit: float,
        starts: tuple[tuple[int, ...], ...],
        options: SolverOptions,
    ) -> QPCCResult:
        start, others = (starts[0], starts[1:]) if starts else (None, ())
        touching = np.array([patch.touching for patch in goals.patches], dtype=bool)
        given = (goals, maps, activations, time_step)
        if self._method == "qpcc" and self._compiled is not None:
            step = step_terms(*given, time_unit=time_unit, cone=self._cone)
            found = self._compiled.solve_step(
                step, start=start, touching=touching, others=others, options=options
            )
            if found is not None:
                return found
        problem = build_qpcc(*given, time_unit=time_unit, cone=self._cone)
        if self._method == "static":
            return solve_static(
                problem,
                touching=touching,
                fallback_controls=activations,
                options=self._rule.kicked,
            )
        return solve_qpcc(
            problem,
            start=start,
            fallback_controls=activations,
            touching=touching,
            others=others,
            options=options,
        )

    def _starts(self, patches: tuple[Patch, ...]) -> tuple[tuple[int, ...], ...]:
        """Modes of the last minima, of the same parts or of as many patches; the best one first."""
        parts = tuple(patch.part for patch in patches)
        if parts == self._parts:
            return self._minima
        if None in parts or None in self._parts:
            return tuple(modes for modes in self._minima if len(modes) == len(patches))
        new = [STICK if patch.touching else LIFT for patch in patches]
        known = (dict(zip(self._parts, modes, strict=True)) for modes in self._minima)
        return tuple(
            tuple(by_part.get(part, mode) for part, mode in zip(parts, new, strict=True))
            for by_part in known
        )


def _planned(view: BodyView, patches: tuple[Patch, ...], result: QPCCResult) -> ContactSample:
    """Mean points of the patches, and what the plan has for them."""
    if not patches or len(result.modes) != len(patches):
        return ContactSample()
    weights = np.array([patch.weights for patch in patches])
    frames = np.array([patch.frame for patch in patches])
    forces = np.einsum("kij,ki->kj", frames, result.forces) / view.horizon
    return ContactSample(
        nodes=np.arange(len(patches), dtype=np.int32),
        points=weights @ view.positions,
        modes=np.array(result.contact_modes, dtype=np.int32),
        forces=forces,
    )
