"""Values that were taken for something else, with what is right for each."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import warp_softbody as wsb
from tests.api.samples import muscled, scene
from warp_softbody.controllers import Balance, Crawl, Goals, Objective
from warp_softbody.controllers.control_solver import ControlSolver
from warp_softbody.errors import InputError, NotFiniteError
from warp_softbody.inputs import checks

NODES = np.array([0, 1], dtype=np.int32)


class Asks:
    """A controller of one objective whose rows are all one number."""

    def __init__(self, value: float, columns: int = 36, *, good: int = 0) -> None:
        """Ask for good rows in the first steps."""
        self.value, self.columns, self.good = value, columns, good

    def goals(self, view: Any) -> Goals:
        """Rows, the more of them the longer it runs."""
        self.good -= 1
        rows = np.full((1, self.columns), 1.0 if self.good >= 0 else self.value)
        return Goals(objectives=(Objective(name="mine", rows=rows, target=0.0, weight=1.0),))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "nodes",
    [[4, 1, 2], (1.0, 2.0, 4.0), {1, 2, 4}, np.array([1, 2, 4, 4]), np.array([4, 2, 1], np.uint8)],
)
def test_node_sets(nodes: Any) -> None:
    assert replace(muscled(), fixed=nodes).fixed.tolist() == [1, 2, 4]


def test_masks_are_the_nodes_that_they_mark() -> None:
    mask = muscled().mesh.points[:, 2] == 0.0
    marked = replace(
        muscled(), fixed=mask, regions={"base": mask.tolist()}, directional_friction=()
    )
    assert marked.fixed.tolist() == np.flatnonzero(mask).tolist()
    for kind in (np.uint8, np.int64, np.float32, object):
        other: Any = replace(muscled(), regions={**muscled().regions, "base": mask.astype(kind)})
        assert other == replace(muscled(), regions={**muscled().regions, "base": mask})
    assert marked.region("base").tolist() == np.flatnonzero(mask).tolist()


@pytest.mark.parametrize(
    "nodes", [[1.7], [2**32 + 3], [-1], [12], [True, False], [[1, 2]], ["1"], 3, None, [np.nan]]
)
def test_what_is_no_node_set(nodes: Any) -> None:
    with pytest.raises(InputError, match="must be node indices from 0 to 11, or 12 truth values"):
        replace(muscled(), fixed=nodes)


@pytest.mark.parametrize(
    "number", [np.float32(0.5), np.array(0.5), Fraction(1, 2), np.float64(0.5)]
)
def test_numbers_of_every_make(number: Any) -> None:
    friction = wsb.Plane(friction=number).friction
    assert type(friction) is float
    assert friction == 0.5


def test_sentences_name_class_field_unit_and_value() -> None:
    for wrong, sentence in (
        ("soft", "Material.young_modulus must be a positive number of Pa, not 'soft'"),
        (10**400, "Material.young_modulus must be a positive number of Pa, not 1000"),
        (1e31, "Material.young_modulus must be a positive number of Pa and below 1e+30 in size"),
    ):
        with pytest.raises(InputError) as caught:
            wsb.Material(young_modulus=wrong)  # type: ignore[arg-type]
        assert str(caught.value).startswith(sentence)
        assert len(str(caught.value)) < 200


@pytest.mark.parametrize("step", [0, -1.0, np.inf, 1e9, np.nan, 1e-300])
def test_time_steps(step: float) -> None:
    with pytest.raises(InputError, match=r"SimulationOptions\.time_step must be a finite number"):
        wsb.Simulation(scene(), time_step=step)
    with pytest.raises(InputError, match=r"SimulationOptions\.time_step"):
        wsb.SimulationOptions(time_step=step)


def test_names() -> None:
    character = muscled()
    for wrong, sentence in (
        ("", "that is not empty"),
        ("\udcff", "that UTF-8 can hold"),
        ("n" * 201, "at most 200 bytes"),
        ("a\nb", "printable"),
    ):
        with pytest.raises(InputError, match=sentence):
            replace(character, name=wrong)
        with pytest.raises(InputError, match=sentence):
            replace(character, regions={wrong: NODES})
        with pytest.raises(InputError, match=sentence):
            replace(character.muscles[0], name=wrong)
    with pytest.raises(InputError, match="two muscle groups of 'bar' have the name 'group'"):
        replace(character, muscles=character.muscles * 2)


def test_names_of_joined_bodies_may_be_long() -> None:
    long = replace(muscled(), name="n" * 200, regions={"r" * 200: NODES})
    others = (wsb.Body(character=wsb.placed(long, name="m" * 200, translation=(1.0, 0.0, 0.0))),)
    whole = wsb.Scene(character=long, others=others).whole
    assert [fiber.name for fiber in whole.fibers] == ["fiber", "m" * 200 + ".fiber"]


def test_regions_of_two_bodies_that_would_be_one() -> None:
    first = replace(muscled(), regions={"b.r": NODES})
    second = replace(wsb.placed(muscled(), name="b"), regions={"r": NODES})
    with pytest.raises(InputError, match=r"two regions of the scene are called 'b\.r'"):
        _ = wsb.Scene(character=first, others=(wsb.Body(character=second),)).whole


@pytest.mark.parametrize("color", ["red", (1.0, 0.0), (2.0, 0.0, 0.0), (np.nan, 0.0, 0.0), 0.5])
def test_colors(color: Any) -> None:
    with pytest.raises(InputError, match=r"Character\.color of 'bar' must be three numbers from 0"):
        replace(muscled(), color=color)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
def test_rows_that_nobody_can_want_stop_the_run(value: float) -> None:
    simulation = wsb.Simulation(scene(), Asks(value, good=9))
    frames = []
    with pytest.raises(InputError, match=r"objective 'mine': rows .* at step 9, 0\.075 s"):
        for frame in simulation.run(1.0):
            frames.append(frame)
    assert len(frames) == 3
    assert simulation.summary().status == "failed"


def test_rows_of_another_body() -> None:
    with pytest.raises(InputError, match="objective 'mine': rows must have 36 columns"):
        list(wsb.Simulation(scene(), Asks(1.0, 12)).run(0.1))


def test_a_controller_that_raises_leaves_no_complete_run() -> None:
    class Raises:
        def goals(self, view: Any) -> Goals:
            raise KeyError("mine")

    simulation = wsb.Simulation(scene(), Raises())
    with pytest.raises(KeyError, match="mine"):
        list(simulation.run(0.1))
    assert simulation.summary().status == "failed"


def test_a_run_that_is_left_is_stopped() -> None:
    simulation = wsb.Simulation(scene())
    frames = simulation.run(0.1)
    next(frames)
    next(frames)
    assert simulation.summary().status == "stopped"
    list(frames)
    assert simulation.summary().status == "complete"


def test_activations_that_are_not_finite(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = wsb.Simulation(scene(), Balance())
    decide = ControlSolver.decide

    def spoilt(*arguments: Any) -> Any:
        decision = decide(*arguments)
        return replace(decision, rest_lengths=decision.rest_lengths * np.nan)

    monkeypatch.setattr(ControlSolver, "decide", spoilt)
    with pytest.raises(NotFiniteError, match="an activation is not finite at step 0"):
        simulation.step()
    assert simulation.summary().status == "not finite"


def test_numbers_that_single_precision_cannot_hold_stop_the_run() -> None:
    """A stiffness of 1e20 Pa, whose squares are beyond float32."""
    stiff = replace(muscled(), material=wsb.Material(young_modulus=1e20))
    simulation = wsb.Simulation(
        replace(scene(), character=stiff), options=wsb.SimulationOptions(precision="float32")
    )
    with pytest.raises(NotFiniteError, match=r"numbers stopped being finite at step 0 .*; try a"):
        simulation.step()
    assert simulation.summary().status == "not finite"


def test_a_class_is_no_controller() -> None:
    with pytest.raises(InputError, match=r"not the class Balance: make one of it by Balance\("):
        wsb.Simulation(scene(), Balance)  # type: ignore[arg-type]


def test_a_controller_without_muscles_is_told() -> None:
    passive = replace(scene(), character=replace(muscled(), muscles=()))
    with pytest.warns(UserWarning, match="has no muscles, so its controller is never asked"):
        wsb.Simulation(passive, Balance())


def test_goals_without_objectives_relax() -> None:
    class Nothing:
        def goals(self, view: Any) -> Goals:
            return Goals(objectives=())

    frames = list(wsb.Simulation(scene(), Nothing()).run(0.1))
    assert np.isfinite(frames[-1].positions).all()


def test_body_weights_need_gravity() -> None:
    floating = replace(scene(), gravity=(0.0, 0.0, 0.0))
    with pytest.raises(InputError, match=r"needs gravity, but Scene\.gravity is \(0\.0, 0\.0, 0"):
        list(wsb.Simulation(floating, Balance()).run(0.1))
    # what reckons in velocities alone needs none
    list(wsb.Simulation(floating, Crawl()).run(0.1))


def test_strange_objects_are_shown() -> None:
    assert checks.shown(np.zeros((3, 4))) == "an array of shape (3, 4) and type float64"
    assert len(checks.shown("x" * 1000)) < 100


def test_rest_lengths_that_are_not_finite_in_a_loop_of_ones_own() -> None:
    model = wsb.build_model(scene(), wsb.SimulationOptions())
    state, after = wsb.State.at_rest(model), wsb.State.at_rest(model)
    control, contacts = wsb.Control.slack(model), wsb.Contacts.none(model)
    stepper = wsb.Stepper(model)
    assert stepper.step(state, control, contacts, after).finite
    control.rest_lengths.assign(np.array([np.nan]))
    with pytest.raises(InputError, match=r"Control\.rest_lengths .* that of segment 0 is nan"):
        stepper.step(state, control, contacts, after)


def test_states_of_another_model_are_refused() -> None:
    model = wsb.build_model(scene(), wsb.SimulationOptions())
    double = wsb.build_model(scene(), wsb.SimulationOptions(precision="float64"))
    bare = wsb.build_model(replace(scene(), ground=None), wsb.SimulationOptions())
    right = (wsb.State.at_rest(model), wsb.Control.slack(model), wsb.Contacts.none(model))
    for other in (double, bare):
        state, control = wsb.State.at_rest(other), wsb.Control.slack(other)
        with pytest.raises(InputError, match=r"must hold \d+ values in float32 for this model"):
            wsb.Stepper(model).step(state, control, wsb.Contacts.none(other), right[0])
    assert wsb.Stepper(model).step(*right, wsb.State.at_rest(model)).finite
