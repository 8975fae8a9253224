"""The run loop: steps a scene under a controller and hands out frames."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.control_options import ControlOptions, Method
from warp_softbody.controllers.control_solver import Decision
from warp_softbody.controllers.controller import Controller, Goals
from warp_softbody.controllers.step_problem import SHORTEST
from warp_softbody.device.array_copies import copied, fits, write_back
from warp_softbody.device.host_view import HostViews
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.workspace import Workspace
from warp_softbody.engine.model import Model, build_model
from warp_softbody.engine.momentum_account import ShapeGauge, Shapes
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.engine.snapshots import Snapshots
from warp_softbody.engine.state import SLACK, Contacts, Control, State
from warp_softbody.engine.step_statistics import StepClock, StepStatistics
from warp_softbody.engine.stepper import Stepper
from warp_softbody.errors import InputError, NotFiniteError
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.run.applied_forces import AppliedForce, applied_force
from warp_softbody.run.continuation import copy_motion, require_same_bodies
from warp_softbody.run.controlled_body import ControlledBody, controlled_bodies, seen_part
from warp_softbody.run.early_kernels import prepare_kernels
from warp_softbody.run.falls import Falls
from warp_softbody.run.goal_report import GoalReport, goal_report
from warp_softbody.run.handle_forces import HandleForces
from warp_softbody.run.handle_motion import HandleMotion
from warp_softbody.run.lookahead import Lookahead
from warp_softbody.run.plan_log import PlanLog
from warp_softbody.run.pushes import Pushes
from warp_softbody.run.run_account import RunAccount
from warp_softbody.run.run_settings import RunSettings
from warp_softbody.run.run_summary import WHOLE, RunSummary
from warp_softbody.run.saved_motion import (
    OTHER_SCENE,
    SavedMotion,
    arrays_of,
    require_same_controllers,
    require_same_scene,
)
from warp_softbody.run.sleep import Sleep
from warp_softbody.run.step_log import StepLog
from warp_softbody.run.step_record import StepObserver, StepRecord
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.world.scene import Scene
from warp_softbody.world.standing import standing_contacts
from warp_softbody.world.view import BodyView

Wish = tuple[ControlledBody, BodyView, Goals]
"""A body, what its controller saw, and what it wants."""


class Simulation:
    """A scene in motion.

    The time step is shortened, where need be, to a whole number of steps per frame.

    Attributes:
        model: what is simulated.
        fps: frames per simulated second.
        name: of the scene, in what is told of the run.
        control_options: of the control solver; the engine's are the model's.
        stepper: takes the steps.
        control: what acts in the next step, written over by pushes and by the controller.
        contacts: as the last step left them.
    """

    @shares_warp
    def __init__(
        self,
        scene: Scene,
        controller: Controller | None = None,
        *,
        others: Mapping[str, Controller] | None = None,
        options: SimulationOptions | None = None,
        control_options: ControlOptions | None = None,
        time_step: float | None = None,
        fps: float = 30.0,
        method: Method | None = None,
        name: str = "scene",
        after: Simulation | None = None,
        like: Model | None = None,
        timed: bool = True,
        workspace: Workspace | None = None,
    ) -> None:
        """Build the model.

        Args:
            scene: what is simulated.
            controller: what is wanted of its character; None for a passive one.
            others: controllers of bodies beside the character, by their names, each for one body.
                Controllers then see their own body alone, and do not know of each other.
            options: of the engine.
            control_options: of the control solver.
            time_step: s, in place of that of the options.
            fps: frames per simulated second.
            method: of the control solver, in place of that of its options.
            name: of the scene, in what is told of the run.
            after: a simulation of the same bodies with the same time step and precision, from whose
                time and motion this one goes on under its own ground, gravity and control. Applied
                forces and observers stay behind.
            like: a model whose constant arrays are shared as far as they are the same
                (`build_model`).
            timed: whether the parts of steps are timed apart, for the summary; a step that no
                controller decides in takes less without.
            workspace: of work arrays that simulations share which never step at the same time.
        """
        begun = time.perf_counter()
        checks.instance("scene of a Simulation", scene, Scene)
        if controller is not None:
            input_kinds.controller("controller of a Simulation", controller)
        others = {} if others is None else input_kinds.mapping("others of a Simulation", others)
        input_kinds.name("name of a Simulation", name)
        controlled = controller is not None or bool(others)
        settings = RunSettings.of(
            options,
            control_options,
            scene=scene,
            controlled=controlled,
            time_step=time_step,
            fps=fps,
            method=method,
        )
        self._timed = checks.truth("timed of a Simulation", timed)
        self._steps_per_frame = settings.steps_per_frame
        prepare_kernels(settings.options, controlled=controlled)
        self.model = build_model(scene, settings.options, like=like)
        self.control_options = settings.control_options
        self.fps = float(fps)
        self.name = name
        self.stepper = Stepper(self.model, workspace=workspace)
        self._state = State.at_rest(self.model)
        self._after = State.at_rest(self.model)
        self.control = Control.slack(self.model)
        self.contacts = Contacts.none(self.model)
        self._lookahead = Lookahead(self.stepper)
        self._controlled = controlled_bodies(
            *(self._lookahead, self.control_options, controller, others, name)
        )
        self.stepper.prepare(self._state, self.control, self.contacts, self._after)
        self._rest_lengths = SLACK * self.model.muscles.rest_lengths
        self._decision: Decision | None = None
        self._snapshots = Snapshots(self.model)
        self._pushes = Pushes(self.model)
        self._handles = HandleMotion(self.model)
        self._handle_forces = HandleForces(
            self.stepper, self.contacts, self._handles, shared=workspace is not None
        )
        self._views = HostViews()
        self._observers: list[StepObserver] = []
        share = self.model.speed_share
        own = self.model.options
        self._sleep = Sleep(own.time_step, allowed=own.sleep, speed_share=share)
        self._driven = False
        self._steps = 0
        self._begun: tuple[StepClock, bool] | None = None
        self._frames = 0
        self._log = StepLog()
        self._plans = PlanLog(scene)
        self._account = RunAccount(self.model)
        self._gauge = ShapeGauge(self.model)
        self._status = "complete"
        if after is not None:
            self._go_on_after(checks.instance("after of a Simulation", after, Simulation))
        self._falls = Falls(self.model, self._upright(), self._state.positions.numpy())
        self._log.setup = time.perf_counter() - begun

    def _go_on_after(self, other: Simulation) -> None:
        """Take over time and motion of a simulation of the same bodies."""
        require_same_bodies(self.model, other.model)
        copy_motion(
            *(other.model, other.state, other.contacts), *(self.model, self._state, self.contacts)
        )
        self._steps = other._steps
        self._handles.go_on_from(self._state, self.time)
        self._set_lengths(other._rest_lengths.copy())

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self._steps * self.model.options.time_step

    @property
    def state(self) -> State:
        """Where the nodes are now, and how they move, on the device; the same arrays all along."""
        return self._state

    @property
    def activations(self) -> FloatArray:
        """(segments,) l_d / l_0 of the last step or `drive`; 1 where a segment is slack."""
        return self._snapshots.activations(self._rest_lengths)

    @property
    def asleep(self) -> bool:
        """Whether steps are left out, since all bodies are at rest."""
        return self._sleep.asleep

    @property
    def shapes(self) -> Shapes:
        """How the bodies were deformed in the last frame, and at most so far."""
        return self._gauge.read()

    def apply_force(
        self,
        nodes: str | npt.ArrayLike,
        force: tuple[float, float, float],
        *,
        weights: npt.ArrayLike | None = None,
    ) -> AppliedForce:
        """Apply a force in all steps to come, until it is changed or removed; return it.

        It acts beside the scene's pushes, and no controller knows of it.

        Args:
            nodes: name of a region, node indices, or a mask of all nodes; those of bodies beside
                the character are numbered as in Scene.parts.
            force: the total, N, (x, y, z).
            weights: (k,) by which the nodes, in ascending order, share it; by mass where none are
                given.

        Raises:
            InputError: there is no such region or node, or a number is not finite.
        """
        applied = applied_force(self.model, nodes, force, weights)
        self._pushes.applied.append(applied)
        return applied

    def drive(self, activations: npt.ArrayLike | None) -> None:
        """Hold the muscles at activations in all steps to come, until they are others.

        Args:
            activations: (segments,) l_d / l_0 from 0.5, as short as a muscle gets, to 1; None lets
                all go slack.

        Raises:
            InputError: a controller drives the muscles, or these are none for them.
        """
        if self._controlled:
            raise InputError(f"drive: a controller drives the muscles of {self.name!r}")
        rest = self.model.muscles.rest_lengths
        self._driven = activations is not None
        if activations is None:
            self._set_lengths(SLACK * rest)
            return
        given = array_checks.array("activations of drive", activations, (len(rest),))
        if given.size and not (SHORTEST <= given.min() and given.max() <= 1.0):
            raise InputError(
                f"activations of drive must be from {SHORTEST:g} to 1, "
                f"not {given.min():.4g} to {given.max():.4g}"
            )
        self._set_lengths(given * rest)

    @shares_warp
    def save(self) -> SavedMotion:
        """The motion as it is, from which `restore` goes on to the last bit.

        Of a controller all its attributes are kept, as what it remembers, and of handles the forces
        of the last step. What has been measured so far is not.

        Raises:
            InputError: what a controller remembers cannot be copied.
        """
        contact = self.stepper.contact
        return SavedMotion(
            scene=self.model.scene,
            time_step=self.model.options.time_step,
            steps=self._steps,
            arrays=copied(self._changing()),
            rest_lengths=self._rest_lengths.copy(),
            driven=self._driven,
            still=self._sleep.still,
            acting=self._pushes.acting,
            aside=self._handles.aside,
            handle_forces=self._handle_forces.read(),
            age=contact.preconditioner.age,
            fresh=contact.fresh,
            controls=tuple(body.save() for body in self._controlled),
            decision=self._decision,
        )

    @shares_warp
    def restore(self, saved: SavedMotion) -> None:
        """Go on from a motion that `save` has kept, of this scene or a copy of it.

        Its controllers have to be of the same classes; they then remember what those remembered
        that were saved, their gains included.

        Raises:
            InputError: it is of another scene, other controllers or another horizon of plans, or in
                other time steps.
        """
        saved = checks.instance("saved of Simulation.restore", saved, SavedMotion)
        require_same_scene(saved, self.model.scene, self.model.options.time_step)
        require_same_controllers(saved, self._controlled)
        if not fits(self._changing(), saved.arrays):
            raise InputError(OTHER_SCENE)
        write_back(self._changing(), saved.arrays)
        self.stepper.take_held(self.control, renew=False)
        self._steps, self._driven = saved.steps, saved.driven
        self._rest_lengths = saved.rest_lengths.copy()
        self._sleep.still, self._pushes.acting = saved.still, saved.acting
        self._handles.return_to(saved.aside, self.time)
        self._handle_forces.put(saved.handle_forces)
        contact = self.stepper.contact
        contact.preconditioner.age, contact.fresh = saved.age, saved.fresh
        for body, control in zip(self._controlled, saved.controls, strict=True):
            body.restore(control)
        self._decision, self._begun = saved.decision, None

    def _upright(self) -> list[str]:
        """Names of the bodies that their controllers are to keep upright now."""
        return [body.name for body in self._controlled if body.keeps_upright]

    def _changing(self) -> Iterator[Any]:
        return arrays_of(self._state, self.control, self.contacts, self.stepper)

    @shares_warp
    def handle_force(self, region: str) -> FloatArray:
        """The force (3,) N with which the handle of a region moved it in the last step.

        It is the mean over the step: what the momentum of its nodes, the rest of their body and
        what they push took. Zero before the first step, and once it has let go.

        Raises:
            InputError: no handle of the scene has that region.
        """
        regions = [handle.region for handle in self.model.scene.handles]
        index = regions.index(checks.choice("handle", region, regions))
        return np.array(self._handle_forces.read()[index])

    def observe(self, observer: StepObserver) -> None:
        """Call ``observer`` with the record of every step to come, once it is taken."""
        wanted = "a function of a StepRecord"
        checks.called_with("observer of a Simulation", observer, 1, wanted)
        self._observers.append(observer)

    def run(self, seconds: float) -> Iterator[Frame]:
        """Frames at t = 0, 1/fps, ... up to ``seconds``.

        Raises:
            NotFiniteError: at the step where numbers stop being finite; frames before it are good.
        """
        seconds = checks.number("seconds of a run", seconds, above=0.0, unit="s")
        return self._frames_until(seconds)

    def _frames_until(self, seconds: float) -> Iterator[Frame]:
        for frame in self._schedule(seconds):
            if frame is None:
                self.step()
            else:
                yield frame

    def schedule(self, seconds: float) -> Iterator[Frame | None]:
        """The frames of `run`, and None wherever a step is to be taken before the next item.

        For those who step many simulations by `begin_step` and `end_step`.
        """
        return self._schedule(checks.number("seconds of a run", seconds, above=0.0, unit="s"))

    def _schedule(self, seconds: float) -> Iterator[Frame | None]:
        # until the last frame is asked for, the run is one that was left
        self._status = "stopped"
        yield self.frame()
        while self.time + 0.5 / self.fps < seconds:
            for _ in range(self._steps_per_frame):
                yield None
            yield self.frame()
        self._status = "complete"

    def step(self) -> None:
        """Advance by one time step.

        Raises:
            NotFiniteError: numbers stopped being finite.
            InputError: a controller asked for what cannot be wanted.
        """
        self.begin_step()
        self.end_step()

    def begin_step(self) -> None:
        """Take a time step but for what `end_step` does, which has to follow.

        Whoever steps many simulations begins the steps of all and then ends them, as caches like.
        """
        try:
            self._begin_step()
        except Exception as error:
            self._note_failure(error)
            raise

    def end_step(self) -> None:
        """Read what the step begun last has come to, and judge it."""
        try:
            self._end_step()
        except Exception as error:
            self._note_failure(error)
            raise

    def _note_failure(self, error: Exception) -> None:
        self._status = "not finite" if isinstance(error, NotFiniteError) else "failed"

    @shares_warp
    def _begin_step(self) -> None:
        self._begun = None
        clock = StepClock()
        pushed = self._pushes.apply(self.control, self._state, self.time)
        wanted = self._goals()
        clock.mark("control")
        moved = self._handles.apply(self.control, self._state, self.time)
        acted = pushed or moved or wanted is not None or self._driven
        if self._sleep.asleep and not acted:
            self._sleep.skip()
            self._steps += 1
            self._log.wall += clock.total
            return
        self._decision = None
        if wanted is None and self._controlled:
            # known before the step, whose matrix then has no muscles in it
            self._set_lengths(SLACK * self.model.muscles.rest_lengths)
        # what a controller decides in is several graphs anyway
        timed = self._timed or wanted is not None
        self.stepper.advance(
            *(self._state, self.control, self.contacts, self._after),
            decide=None if wanted is None else lambda: self._decide(wanted),
            clock=clock if timed else None,
        )
        self._handle_forces.note_step()
        clock.mark("contact" if timed else WHOLE)
        self._begun = (clock, acted)

    @shares_warp
    def _end_step(self) -> None:
        if self._begun is None:
            return
        (clock, acted), self._begun = self._begun, None
        statistics = self.stepper.conclude()
        self._refuse_nonsense(statistics)
        begun = self.time
        self.stepper.exchange(self._state, self._after)
        self._account.note(statistics, begun)
        self._steps += 1
        self._sleep.note(statistics.fastest, acted=acted)
        self._log.note(statistics, self._decision, clock, first=self._steps == 1)
        if self._decision is not None:
            self._plans.note(self._decision, self._state, self.control)
        if self._observers:
            self._show(statistics, begun, clock)

    def _show(self, statistics: StepStatistics, begun: float, clock: StepClock) -> None:
        """Hand the record of the last step, which began at a time, s, to those who observe."""
        record = StepRecord(
            index=self._steps - 1,
            time=begun,
            statistics=statistics,
            decision=self._decision,
            before=self._after,
            state=self._state,
            control=self.control,
            contacts=self.contacts,
            seconds=clock.seconds,
        )
        for observer in self._observers:
            observer(record)

    def _refuse_nonsense(self, statistics: StepStatistics) -> None:
        """Stop a run whose step is not finite, too far away, or has its momentum from nowhere."""
        options, what = self.model.options, None
        if not statistics.finite:
            what = "numbers stopped being finite"
        elif not statistics.resolved:
            what = f"nodes are too far away for {options.precision} to tell them apart"
        elif not statistics.converged and self._account.has_diverged(self.stepper.account()):
            what = "a linear solve diverged, and more momentum came from nowhere than from forces"
        if what is None:
            return
        self._status = "not finite"
        other = " or precision float64" if options.precision == "float32" else ""
        raise NotFiniteError(
            f"{what} at step {self._steps} ({self.time:.4f} s) of {self.name!r}; "
            f"try a smaller time_step than {options.time_step:g} s{other}",
            step=self._steps,
            time=self.time,
        )

    def interrupt(self) -> None:
        """Note that the run was broken off by the user."""
        self._status = "interrupted"

    def summary(self, stage: str | None = None) -> RunSummary:
        """The run so far in numbers."""
        positions = self._state.positions.numpy().astype(np.float64)
        measured = (self.stepper.account(), self._gauge.read(), positions)
        findings = self._account.findings(*measured)
        fallen, plans = self._falls.doubts(positions, self._upright()), self._plans.misses()
        # plans that take all contacts for static are a baseline, and known to miss their steps
        baseline = self.control_options.method == "static"
        unplanned = () if plans is None or baseline else plans.doubts()
        findings = replace(findings, doubts=(*findings.doubts, *fallen, *unplanned))
        return self._log.summary(
            self.model,
            findings,
            scene=self.name,
            frames=self._frames,
            simulated_seconds=self.time,
            slept_steps=self._sleep.slept,
            controlled=bool(self._controlled),
            motions=self._controlled[0].course if self._controlled else (),
            plans=plans,
            status=self._status,
            stage=stage,
        )

    def goal_report(self) -> GoalReport:
        """What the character's controller wanted of the last step, and what came of it.

        Raises:
            InputError: no controller decided in the last step.
        """
        if self._decision is None:
            raise InputError(f"no controller of {self.name!r} has decided in the last step")
        velocities = self._state.velocities.numpy().astype(np.float64)
        nodes, _ = seen_part(self.model.scene, self._decision.view)
        course = self._controlled[0].course
        return goal_report(
            self._decision,
            velocities[nodes],
            course[-1].name if course else None,
        )

    def count_export(self, seconds: float) -> None:
        """Add the wall time that the receiver of the last frame took, shared by its steps."""
        self._log.count_export(seconds)

    @shares_warp
    def view(self) -> BodyView:
        """The state as a controller sees it."""
        return self._snapshots.view(self._state, self.contacts, self._rest_lengths, self.time)

    def _goals(self) -> list[Wish] | None:
        """What controllers want of the step, and what they saw; None where none wants anything."""
        if not self._controlled:
            return None
        whole, found = self.view(), []
        for body in self._controlled:
            view = body.view(whole)
            try:
                goals = body.goals(view)
            except InputError as error:
                raise InputError(
                    f"{error} (asked for by the controller at step {self._steps}, "
                    f"{self.time:.4g} s)"
                ) from error
            if goals is not None:
                found.append((body, view, goals))
        return found or None

    def _decide(self, wishes: list[Wish]) -> None:
        """Set the muscles of the step whose matrix is assembled; those of limp bodies are slack."""
        self._lookahead.assemble(self._state, self.control)
        lengths = SLACK * self.model.muscles.rest_lengths
        for body, view, goals in wishes:
            try:
                decision = body.decide(view, goals)
            except InputError as error:
                raise InputError(
                    f"{error} (step {self._steps}, {self.time:.4g} s of {self.name!r})"
                ) from error
            if body is self._controlled[0]:
                self._decision = decision
            lengths[body.segments] = decision.rest_lengths
        if not np.isfinite(lengths).all():
            raise NotFiniteError(
                f"an activation is not finite at step {self._steps} ({self.time:.4f} s) of "
                f"{self.name!r}",
                step=self._steps,
                time=self.time,
            )
        self._set_lengths(lengths)

    def _set_lengths(self, lengths: FloatArray) -> None:
        self._rest_lengths = lengths
        self._views.write(self.control.rest_lengths, lengths)

    @shares_warp
    def frame(self) -> Frame:
        """Return the scene as it is now; each call is counted as a frame that is handed out."""
        planned = ContactSample() if self._decision is None else self._decision.planned
        now = (self._state, self.contacts, self._rest_lengths, planned)
        frame = self._snapshots.frame(self._frames, self.time, *now)
        if self._steps == 0:
            stands = standing_contacts(self.model.scene, frame.positions)
            frame = replace(frame, contacts=stands)
        self._gauge.measure(self._state)
        self._frames += 1
        return frame
