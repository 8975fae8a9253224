"""Gains in units of the body: what the units are, and what becomes of gains in them."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box
from warp_softbody import Character, Scene, controllers
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost

GAINS = (
    controllers.BalanceGains(),
    controllers.CrawlGains(arch=0.2),
    controllers.ExerciseGains(),
    controllers.JumpGains(way=(0.1, 0.2), rise=0.1, turn=0.3),
    controllers.Leg(direction=1.0, turn=2.0),
    controllers.RecoveryGains(leave=1.2),
    controllers.RollGains(),
    controllers.SlideGains(),
    controllers.Sway(),
    controllers.WalkGains(),
)


@dataclass(frozen=True, kw_only=True)
class Inner:
    """A length and a pure number."""

    far: float = field(default=2.0, metadata=dimension(length=1.0))
    share: float = 0.5


@dataclass(frozen=True, kw_only=True)
class Outer:
    """Every kind of field that gains have."""

    spring: float = field(default=3.0, metadata=dimension(time=-2.0))
    launch: tuple[float, float] = field(
        default=(1.0, -2.0), metadata=dimension(length=1.0, time=-1.0)
    )
    inner: Inner = field(default_factory=Inner)
    activation: ActivationCost = field(default_factory=ActivationCost)


def test_units_are_the_longest_side_and_its_pendulum_s_time() -> None:
    """Of the character alone; without gravity, of Earth's."""
    body = Character(name="box", mesh=box((1, 1, 1), (0.3, 0.2, 0.9)))
    units = BodyUnits.of_scene(Scene(character=body, gravity=(0.0, -0.8, -0.6)))
    assert (units.length, units.time) == pytest.approx((0.9, np.sqrt(0.9)), rel=1e-12)
    assert units.speed == pytest.approx(np.sqrt(0.9), rel=1e-12)
    floating = BodyUnits.of_scene(Scene(character=body, gravity=(0.0, 0.0, 0.0)))
    assert floating.time == pytest.approx(np.sqrt(0.9 / 9.81), rel=1e-12)


def test_fields_are_multiplied_by_their_units() -> None:
    """Tuples and dataclasses among them too; pure numbers, and costs of activation, stay."""
    found = in_si(Outer(), BodyUnits(length=4.0, time=0.5))
    assert found == Outer(
        spring=12.0, launch=(8.0, -16.0), inner=Inner(far=8.0), activation=ActivationCost()
    )


@pytest.mark.parametrize("gains", GAINS, ids=lambda gains: type(gains).__name__)
def test_gains_of_a_letter_are_those_of_a_metre_in_its_units(gains: Any) -> None:
    """A frequency means the same in swings of any pendulum, a length as a share of any body."""
    metre = BodyUnits(length=1.0, time=9.81**-0.5)
    ten = BodyUnits(length=10.0, time=(10.0 / 9.81) ** 0.5)
    one, other = in_si(gains, metre), in_si(gains, ten)
    assert in_si(gains, BodyUnits(length=1.0, time=1.0)) == gains
    changed = [name for name in names(gains) if getattr(one, name) != getattr(gains, name)]
    assert changed and "activation" not in changed
    for name in names(gains):
        here, there = np.array([getattr(one, name), getattr(other, name)])
        size = np.asarray(here)
        if name == "position" or (name, type(gains)) == ("tilt", controllers.SlideGains):
            np.testing.assert_allclose(there, 0.1 * size)
        elif name in ("velocity", "push", "foot_velocity", "steadiness", "reach_rate"):
            np.testing.assert_allclose(there, 0.1**0.5 * size)
        elif name in ("depth", "lean", "reach", "stride", "lift", "amplitude", "relax_within"):
            # the slide's lean is a share, not a way
            factor = 1.0 if isinstance(gains, controllers.SlideGains) else 10.0
            np.testing.assert_allclose(there, factor * size)
        elif name in ("crouch_time", "swing", "period", "pull_time", "longest"):
            np.testing.assert_allclose(there, 10.0**0.5 * size)


def names(gains: Any) -> list[str]:
    """Of the fields that are numbers or tuples of numbers."""
    return [
        entry.name
        for entry in fields(gains)
        if isinstance(getattr(gains, entry.name), float | tuple)
    ]


def test_landing_gains_are_among_those_of_a_jump() -> None:
    landing = controllers.BalanceGains(position=2.0)
    found = in_si(controllers.JumpGains(landing=landing), BodyUnits(length=1.0, time=0.5))
    assert found.landing == in_si(landing, BodyUnits(length=1.0, time=0.5))
    assert found.landing.position == 8.0 and replace(landing, position=2.0) == landing
