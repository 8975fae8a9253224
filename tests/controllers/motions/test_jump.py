"""Jumps: what is asked at take-off is what the body has there, and its flight is what follows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.controller import Goals
from warp_softbody.controllers.motions.jump import Jump, JumpPhase
from warp_softbody.engine.options import SimulationOptions, Tangent
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes import jump_i, jump_t
from warp_softbody.world.view import BodyView

STEPS = (1.0 / 60.0, 1.0 / 120.0)


@dataclass(frozen=True)
class Flight:
    """What a body is before its base is lifted, in the air and when it has landed again."""

    before: BodyView
    above: BodyView
    landed: BodyView
    base: FloatArray


class Watched:
    """A jump whose first view in every phase is kept."""

    def __init__(self, jump: Jump) -> None:
        """Of a jump that has not begun."""
        self._jump = jump
        self.seen: dict[JumpPhase, BodyView] = {}

    def goals(self, view: BodyView) -> Goals:
        """What the jump wants."""
        wanted = self._jump.goals(view)
        self.seen.setdefault(self._jump.phase, view)
        return wanted


@cache
def flown(name: str, time_step: float, tangent: Tangent = "auto") -> Flight:
    """The first flight of a scene."""
    plan = scenes.make(name)
    assert isinstance(plan.controller, Jump)
    watched = Watched(plan.controller)
    options = SimulationOptions(time_step=time_step, tangent=tangent)
    simulation = Simulation(plan.scene, watched, options=options)
    while JumpPhase.LAND not in watched.seen and simulation.time < 3.0:
        simulation.step()
    above, landed = watched.seen[JumpPhase.FLY], watched.seen[JumpPhase.LAND]
    # a body may leave in the very step in which it is fast enough
    before = watched.seen.get(JumpPhase.LIFT, above)
    base = landed.positions[plan.scene.character.region("base")].mean(axis=0)
    return Flight(before, above, landed, base)


@pytest.mark.parametrize("tangent", ["auto", "warped"])
@pytest.mark.parametrize("time_step", STEPS)
@pytest.mark.parametrize("name", ["jump-i", "jump-i-in-place", "jump-t"])
def test_the_body_rises_as_fast_as_asked_when_its_base_is_lifted(
    name: str, time_step: float, tangent: Tangent
) -> None:
    """From 0.94 of it on; a step of the ramp more is what it may be late."""
    gains = jump_t.TWIST if name == "jump-t" else jump_i.IN_PLACE
    asked = gains.launch[2] * np.sqrt(9.81)
    view = flown(name, time_step, tangent).before
    speed = view.linear_momentum[2] / view.mass
    assert 0.9 * asked < speed < 1.08 * asked


@pytest.mark.parametrize("time_step", STEPS)
@pytest.mark.parametrize("name", ["jump-i", "jump-i-in-place", "jump-t"])
def test_the_ground_gives_nothing_more_once_the_base_is_lifted(name: str, time_step: float) -> None:
    """Gravity alone acts from the lift to the flight, to a tenth of the weight."""
    flight = flown(name, time_step)
    before, above = flight.before, flight.above
    fall = (before.linear_momentum - above.linear_momentum) / before.mass
    seconds = above.time - before.time
    assert 0.0 < seconds < 0.05
    np.testing.assert_allclose(fall / (9.81 * seconds), [0.0, 0.0, 1.0], atol=0.1)


@pytest.mark.parametrize("time_step", STEPS)
def test_letter_t_has_the_spin_with_which_it_turns_as_asked(time_step: float) -> None:
    """H_z over the moment of inertia and times the flight it was asked for."""
    flight = flown("jump-t", time_step)
    view, gains = flight.before, jump_t.TWIST
    squares = ((view.positions - view.center_of_mass) ** 2)[:, :2].sum(axis=1)
    rate = view.angular_momentum[2] / (view.masses @ squares)
    speed, drop = gains.launch[2] * np.sqrt(9.81), view.center_of_mass[2] - gains.height
    airtime = (speed + np.sqrt(speed**2 + 2.0 * 9.81 * drop)) / 9.81
    assert rate * airtime == pytest.approx(gains.turn, rel=0.15)


@pytest.mark.parametrize("time_step", STEPS)
def test_a_hop_lands_where_it_should(time_step: float) -> None:
    flight = flown("jump-i", time_step)
    assert flight.base[0] == pytest.approx(jump_i.FORWARD.way[0], abs=0.02)
    assert abs(flight.base[1]) < 0.01


def test_the_sole_is_the_lowest_segment_of_every_fibre() -> None:
    assert jump_i.sole(jump_i.jumping_letter()) == (0, 12, 24, 36)
    assert jump_i.sole(jump_t.twisting_letter()) == (0, 6, 12, 18, 24, 33, 42)
