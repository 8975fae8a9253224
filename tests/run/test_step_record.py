"""Observers of a run, and a loop of one's own that takes the same steps."""

from __future__ import annotations

import numpy as np
import pytest

import warp_softbody as wsb
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.control_solver import ControlSolver
from warp_softbody.engine.snapshots import Snapshots
from warp_softbody.engine.state import SLACK
from warp_softbody.errors import InputError
from warp_softbody.run.step_record import StepRecord

STEPS = 5


def balancing() -> tuple[wsb.Simulation, wsb.controllers.Controller]:
    plan = wsb.scenes.make("balance-i")
    assert plan.controller is not None
    simulation = wsb.Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    return simulation, wsb.scenes.make("balance-i").controller  # type: ignore[return-value]


def arrays(state: wsb.State) -> FloatArray:
    parts = (state.positions, state.velocities, state.increments, state.carry)
    return np.concatenate([part.numpy() for part in parts]).astype(np.float64)


def test_every_step_is_shown_to_its_observers() -> None:
    simulation, _ = balancing()
    seen: list[StepRecord] = []
    twice: list[int] = []
    begun, ended = [], []

    def keep(step: StepRecord) -> None:
        begun.append(arrays(step.before))
        ended.append(arrays(step.state))

    simulation.observe(seen.append)
    simulation.observe(keep)
    simulation.observe(lambda step: twice.append(step.index))
    for _ in range(STEPS):
        simulation.step()
    assert [step.index for step in seen] == twice == list(range(STEPS))
    dt = simulation.model.options.time_step
    np.testing.assert_allclose([step.time for step in seen], dt * np.arange(STEPS))
    assert seen[-1].state is simulation.state
    assert not np.array_equal(begun[-1], ended[-1])
    # each step begins with all that the one before it left, from the start on
    np.testing.assert_array_equal(begun[1:], ended[:-1])
    np.testing.assert_array_equal(begun[0], arrays(wsb.State.at_rest(simulation.model)))
    assert seen[-1].control is simulation.control and seen[-1].contacts is simulation.contacts
    assert all(step.statistics.iterations > 0 and step.decision is not None for step in seen)
    for step in seen:
        assert set(step.seconds) == {"control", "assembly", "solve", "contact"}
        assert min(step.seconds.values()) > 0.0


def test_a_sleeping_scene_s_steps_are_not_shown() -> None:
    plan = wsb.scenes.make("drop-block")
    simulation = wsb.Simulation(plan.scene, time_step=plan.time_step)
    seen: list[StepRecord] = []
    simulation.observe(seen.append)
    while not simulation.asleep:
        simulation.step()
    taken = len(seen)
    simulation.step()
    assert len(seen) == taken > 0 and seen[0].decision is None


def test_an_observer_takes_one_argument() -> None:
    simulation, _ = balancing()
    with pytest.raises(InputError, match="observer of a Simulation must be a function of a Step"):
        simulation.observe(lambda: None)  # type: ignore[arg-type, misc]


def test_a_loop_of_one_s_own_takes_the_same_steps() -> None:
    """Bit for bit, with the control decided between the assembly and the solve."""
    simulation, controller = balancing()
    model = simulation.model
    stepper, snapshots = wsb.Stepper(model), Snapshots(model)
    solver = ControlSolver(controller, wsb.ReducedDynamics(stepper), ControlOptions())
    state, after = wsb.State.at_rest(model), wsb.State.at_rest(model)
    control, contacts = wsb.Control.slack(model), wsb.Contacts.none(model)
    lengths = SLACK * model.muscles.rest_lengths
    for step in range(STEPS):
        view = snapshots.view(state, contacts, lengths, step * model.options.time_step)
        goals = solver.goals(view)
        assert goals is not None

        def decide() -> None:
            nonlocal lengths
            lengths = solver.decide(view, goals).rest_lengths  # noqa: B023
            control.rest_lengths.assign(lengths)

        stepper.step(state, control, contacts, after, decide=decide)
        state, after = after, state
        simulation.step()
    np.testing.assert_array_equal(state.positions.numpy(), simulation.state.positions.numpy())
