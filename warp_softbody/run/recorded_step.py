"""One step of a run in numbers, as a `Recorder` keeps them."""

from __future__ import annotations

from collections import Counter

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.control_solver import Decision
from warp_softbody.controllers.controller import Goals
from warp_softbody.engine.energies import EnergyMeter
from warp_softbody.engine.model import Model
from warp_softbody.engine.snapshots import Snapshots
from warp_softbody.run.controlled_body import seen_part
from warp_softbody.run.plan_outcome import plan_outcome
from warp_softbody.run.step_record import StepRecord
from warp_softbody.world.frame import ContactSample, Frame

Numbers = dict[str, FloatArray]


class StepMeter:
    """Measures the steps of a model."""

    def __init__(self, model: Model) -> None:
        """Prepare what all steps share."""
        self._model = model
        self._snapshots = Snapshots(model)
        self._energies = EnergyMeter(model)
        self._masses = [model.masses[part.nodes] for part in model.scene.parts]

    def measure(self, step: StepRecord) -> tuple[Numbers, ContactSample]:
        """Numbers by name, as in `Recorder`, and the contacts that the step ended with."""
        lengths = np.array(step.control.rest_lengths.numpy(), dtype=np.float64)
        time = step.time + self._model.options.time_step
        now = (step.state, step.contacts, lengths, ContactSample())
        frame = self._snapshots.frame(step.index + 1, time, *now)
        energies = self._energies.measure(frame.positions, frame.velocities, lengths)
        return {
            "time": np.float64(time),
            **self._momenta(frame),
            **self._contact(frame.contacts),
            "activations": frame.activations,
            **{f"energy/{name}": value for name, value in energies._asdict().items()},
            **self._decided(step, frame),
            **_costs(step),
        }, frame.contacts

    def _momenta(self, frame: Frame) -> Numbers:
        centres, linear, angular = [], [], []
        for part, masses in zip(self._model.scene.parts, self._masses, strict=True):
            places, moving = frame.positions[part.nodes], frame.velocities[part.nodes]
            centre = masses @ places / masses.sum()
            momenta = masses[:, None] * moving
            centres.append(centre)
            linear.append(momenta.sum(axis=0))
            angular.append(np.cross(places - centre, momenta).sum(axis=0))
        return {
            "centre_of_mass": np.array(centres),
            "momentum": np.array(linear),
            "angular_momentum": np.array(angular),
        }

    def _decided(self, step: StepRecord, frame: Frame) -> Numbers:
        """Goals and plan of the first body that is controlled."""
        decision = step.decision
        if decision is None:
            return {}
        nodes, segments = seen_part(self._model.scene, decision.view)
        velocities, chosen = frame.velocities[nodes], frame.activations[segments]
        found = _objectives(decision, velocities, chosen)
        if decision.converged:
            pushes = np.array(step.control.external_forces.numpy(), dtype=np.float64)
            found |= _plan(decision, velocities, pushes[nodes])
        return found

    def _contact(self, contacts: ContactSample) -> Numbers:
        bodies = range(len(self._masses))
        count = len(self._masses)
        return {
            "contact_force": np.array([contacts.force_on(body) for body in bodies]),
            "sticking": np.bincount(
                contacts.bodies[contacts.modes == ContactMode.STICK], minlength=count
            ),
            "sliding": np.bincount(
                contacts.bodies[contacts.modes == ContactMode.SLIDE], minlength=count
            ),
        }


def _objectives(decision: Decision, velocities: FloatArray, activations: FloatArray) -> Numbers:
    """What the plan expected to be left of all goals, and what the step has left of each.

    Of a plan that looks further ahead, what is left if all goes on as in the step.
    """
    view = decision.view
    velocities = view.at_horizon(view.velocities, velocities).reshape(-1)
    left: Numbers = {"objective/planned": np.float64(decision.result.objective)}
    counted: Counter[str] = Counter()
    for goal in decision.goals.objectives:
        counted[goal.name] += 1
        number = f" {counted[goal.name]}" if counted[goal.name] > 1 else ""
        miss = goal.rows @ velocities - goal.target
        left[f"objective/{goal.name}{number}"] = np.asarray(goal.weight @ miss**2)
    spent = _activation_cost(decision.goals, decision, activations)
    reached = sum(float(value) for name, value in left.items() if name != "objective/planned")
    reached += sum(float(value) for value in spent.values())
    return {**left, **spent, "objective/reached": np.float64(reached)}


def _plan(decision: Decision, velocities: FloatArray, pushes: FloatArray) -> Numbers:
    """What the plan expected of the body, and by how much the step misses it."""
    found = plan_outcome(decision, velocities, pushes)
    return {
        "plan/momentum": found.momentum_planned,
        "plan/angular_momentum": found.spin_planned,
        "plan/contact_share": np.float64(found.share_planned),
        "plan/contact_share_reached": np.float64(found.share),
        "plan/momentum_miss": np.float64(found.momentum_miss),
        "plan/feet_miss": np.float64(found.feet_miss),
        "plan/cost_miss": np.float64(found.cost_miss),
    }


def _activation_cost(goals: Goals, decision: Decision, chosen: FloatArray) -> Numbers:
    """Cost of the activations and of their change, as in `ActivationCost`."""
    rate = goals.activation.change / (decision.view.horizon / decision.time_unit)
    chosen = decision.view.at_horizon(decision.view.activations, chosen)
    change = chosen - decision.view.activations
    return {
        "objective/effort": np.asarray(goals.activation.effort * np.mean((chosen - 1.0) ** 2)),
        "objective/change of activations": np.asarray(rate * np.mean(change**2)),
    }


def _costs(step: StepRecord) -> Numbers:
    decision, statistics = step.decision, step.statistics
    return {
        "qps": np.int64(0 if decision is None else decision.result.qp_count),
        "cg_iterations": np.int64(statistics.iterations),
        "contact_passes": np.int64(statistics.passes),
        **{f"milliseconds/{part}": np.float64(1e3 * s) for part, s in step.seconds.items()},
    }
