"""Every field of the option classes refuses what it cannot be, wherever it is given."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import FrozenInstanceError, fields, replace
from typing import Any

import pytest

import warp_softbody as wsb
from tests.api.samples import muscled, scene, stepper
from warp_softbody.cli import main
from warp_softbody.controllers import Balance
from warp_softbody.controllers.control_solver import ControlSolver
from warp_softbody.errors import InputError
from warp_softbody.inputs.option_fields import Option, check_options, options_of, recorded
from warp_softbody.inputs.option_kinds import ChoiceKind, NumberKind, TruthKind, WholeKind

CLASSES: dict[str, type[Any]] = {
    "SimulationOptions": wsb.SimulationOptions,
    "ControlOptions": wsb.ControlOptions,
}
EVERY = [one for owner in CLASSES.values() for one in options_of(owner)]
BAD_STEPS = [0, 0.0, -0.01, math.nan, math.inf, 1e9]


def wrong_values(one: Option) -> Iterator[Any]:
    """Values of the wrong type, and just outside the range."""
    yield from ("soft", [1], 1j)
    if one.unset is None:
        yield None
    kind = one.kind
    if isinstance(kind, NumberKind):
        yield from (math.nan, math.inf, -math.inf, True)
        yield from (kind.low - abs(kind.low) - 1.0, 2.0 * kind.high)
        yield from (end for end in (kind.above, kind.below) if math.isfinite(end))
    elif isinstance(kind, WholeKind):
        yield from (math.nan, kind.low - 1, kind.low + 0.5, True, 2**40)
        yield from () if kind.high is None else (kind.high + 1,)
    elif isinstance(kind, ChoiceKind):
        yield from ("", True, 3, f"{kind.known[0]} ")
    elif isinstance(kind, TruthKind):
        yield from (0, 1, "on", math.nan)


def right_values(one: Option) -> Iterator[Any]:
    """The default and the ends of the range."""
    yield one.default
    kind = one.kind
    if isinstance(kind, NumberKind):
        ends = (kind.low, kind.high) if math.isinf(kind.above) else (1e-12, 0.999)
        yield from (end for end in ends if abs(end) < 1e30)
    elif isinstance(kind, WholeKind):
        yield from (kind.low, kind.high or 10**6)
    elif isinstance(kind, ChoiceKind):
        yield from kind.known
    elif isinstance(kind, TruthKind):
        yield from (True, False)


def wrong_texts(one: Option) -> Iterator[str]:
    """What a flag refuses."""
    yield from ("soft", "", "1e400")
    kind = one.kind
    if isinstance(kind, NumberKind):
        yield from ("nan", "-inf", str(kind.low - abs(kind.low) - 1.0))
    elif isinstance(kind, WholeKind):
        yield from (str(kind.low - 1), "1.5", "nan")


def name_of(one: object) -> str:
    return f"{one.owner}.{one.name}" if isinstance(one, Option) else str(one)


each_option = pytest.mark.parametrize("one", EVERY, ids=name_of)


@each_option
def test_constructors_refuse_in_one_sentence(one: Option) -> None:
    for value in wrong_values(one):
        with pytest.raises(InputError) as caught:
            CLASSES[one.owner](**{one.name: value})
        assert str(caught.value).startswith(f"{one.owner}.{one.name} must be "), value
        assert len(str(caught.value)) < 250 and "\n" not in str(caught.value)
        with pytest.raises(InputError):
            replace(CLASSES[one.owner](), **{one.name: value})


@each_option
def test_constructors_take_the_ends_of_the_range(one: Option) -> None:
    for value in right_values(one):
        kept = getattr(CLASSES[one.owner](**{one.name: value}), one.name)
        assert kept == value and type(kept) is type(one.check(value))


@each_option
def test_what_went_round_a_constructor_is_refused_where_it_is_used(one: Option) -> None:
    """By the run loop, and by a loop of one's own: of the stepper, or of the control solver."""
    for value in wrong_values(one):
        bent = CLASSES[one.owner]()
        with pytest.raises(FrozenInstanceError):
            setattr(bent, one.name, value)
        object.__setattr__(bent, one.name, value)
        if one.owner == "SimulationOptions":
            with pytest.raises(InputError, match=rf"{one.owner}\.{one.name} must be "):
                wsb.build_model(scene(), bent)
            with pytest.raises(InputError, match=rf"{one.owner}\.{one.name} must be "):
                wsb.Simulation(scene(), options=bent)
        else:
            with pytest.raises(InputError, match=rf"{one.owner}\.{one.name} must be "):
                ControlSolver(Balance(), wsb.ReducedDynamics(stepper()), bent)
            with pytest.raises(InputError, match=rf"{one.owner}\.{one.name} must be "):
                wsb.Simulation(scene(), Balance(), control_options=bent)


@pytest.mark.parametrize("one", [one for one in EVERY if one.flag], ids=name_of)
def test_flags_refuse_in_one_sentence(one: Option, capsys: pytest.CaptureFixture[str]) -> None:
    for text in wrong_texts(one):
        assert main(["run", "balance-i", f"{one.flag_name}={text}"]) == 2, text
        printed = capsys.readouterr()
        assert printed.out == "" and printed.err.count("\n") == 1
        assert printed.err.startswith(f"warp-softbody: {one.flag_name}")


@pytest.mark.parametrize("step", BAD_STEPS)
def test_time_steps_are_refused_everywhere(step: float, capsys: pytest.CaptureFixture[str]) -> None:
    sentence = r"SimulationOptions\.time_step must be a finite number of s from 1e-09 to 10000, not"
    for given in (
        lambda: wsb.SimulationOptions(time_step=step),
        lambda: wsb.Simulation(scene(), time_step=step),
        lambda: wsb.Simulation(scene(), options=wsb.SimulationOptions(time_step=step)),
        lambda: wsb.build_model(scene(), wsb.SimulationOptions(time_step=step)),
        lambda: wsb.Stepper(wsb.build_model(scene(), wsb.SimulationOptions(time_step=step))),
    ):
        with pytest.raises(InputError, match=sentence):
            given()
    assert main(["run", "balance-i", f"--time-step={step}"]) == 2
    assert "--time-step: must be a finite number of s" in capsys.readouterr().err


def test_the_shorthands_of_a_simulation_are_checked() -> None:
    with pytest.raises(InputError, match=r"ControlOptions\.method must be one of qpcc, static"):
        wsb.Simulation(scene(), method="pid")  # type: ignore[arg-type]
    for name, wrong in (("options", wsb.ControlOptions()), ("control_options", 3)):
        with pytest.raises(InputError, match=f"{name} of a Simulation must be a"):
            wsb.Simulation(scene(), **{name: wrong})  # type: ignore[arg-type]


def test_options_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(InputError, match="smoothed elements have no exact tangent"):
        wsb.SimulationOptions(elements="smoothed", tangent="exact")
    bent = wsb.SimulationOptions(elements="smoothed")
    object.__setattr__(bent, "tangent", "exact")
    with pytest.raises(InputError, match="smoothed elements have no exact tangent"):
        wsb.build_model(scene(), bent)


@pytest.mark.parametrize("owner", CLASSES.values())
def test_fields_describe_themselves(owner: type[Any]) -> None:
    assert [one.name for one in options_of(owner)] == [one.name for one in fields(owner)]
    for one in options_of(owner):
        assert len(one.help) > 10 and one.kind.range
        assert one.check(one.default) == one.default
        assert (one.default is None) <= (one.unset is not None)
        assert f"    {one.name}" in str(owner.__doc__)


def test_a_run_tells_its_options() -> None:
    options = wsb.SimulationOptions(threads=2, preconditioner="factor")
    told = recorded(options)
    assert (told["threads"], told["preconditioner"]) == (2, "factor")
    assert "threads" not in recorded(options, motion_only=True)
    assert "method" not in recorded(wsb.ControlOptions())


def test_checked_values_are_plain() -> None:
    options = wsb.SimulationOptions(newton_iterations=2.0)  # type: ignore[arg-type]
    assert type(options.newton_iterations) is int
    check_options(options)


def test_options_reach_the_control_solver() -> None:
    """One QP a step where one is allowed, and a planned cone of four directions."""
    control = wsb.ControlOptions(max_qps=1, planned_cone=4, response_tolerance=1e-5)
    simulation = wsb.Simulation(
        replace(scene(), character=muscled()), Balance(), control_options=control
    )
    for _ in range(5):
        simulation.step()
    assert simulation.summary().qps_per_step.p95 <= 1.0
