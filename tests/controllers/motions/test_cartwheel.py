"""Cartwheels: what the plan does, and which bodies turn them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import Plane, Scene, Simulation
from warp_softbody.characters import letter_i, letter_x_upright
from warp_softbody.controllers import Balance, Cartwheel, CartwheelGains, Motion, Sequence
from warp_softbody.controllers.motions.limb_feet import FEET
from warp_softbody.errors import InputError
from warp_softbody.scenes.cartwheel_x import GAINS, turning_letter


def scene() -> Scene:
    return Scene(character=turning_letter(2.0), ground=Plane(friction=0.8))


def test_the_plan_waits_for_a_body_that_is_held() -> None:
    letter = turning_letter(2.0)
    held = replace(letter, fixed=letter.region("base"))
    controller = Cartwheel(GAINS, start=0.0)
    simulation = Simulation(
        Scene(character=held, ground=Plane()), controller, time_step=1.0 / 60.0, fps=60.0
    )
    for _ in simulation.run(4.0):
        pass
    assert not controller.interruptible and not controller.finished
    # it stops a lead ahead, and the way that it takes to stop further
    assert 0.0 < controller.phase < 2.0 * GAINS.lead


def test_it_turns_the_other_way() -> None:
    ways = []
    for direction in (1.0, -1.0):
        controller = Cartwheel(GAINS, direction=direction, start=0.0)
        simulation = Simulation(scene(), controller, time_step=1.0 / 60.0, fps=60.0)
        *_, last = simulation.run(1.6)
        ways.append(float(last.positions[:, 0].mean()))
    assert ways[0] > 0.4
    assert ways[1] == pytest.approx(-ways[0], rel=0.1)


def test_any_body_with_limbs_around_it_has_gains() -> None:
    made = Cartwheel.for_(letter_x_upright(), turns=2, direction=-1.0)
    assert isinstance(made, Cartwheel)
    with pytest.raises(InputError, match="Cartwheel needs 3 regions 'foot_"):
        Cartwheel.for_(letter_i())
    character = letter_x_upright()
    with pytest.raises(InputError, match="Cartwheel needs muscles"):
        Cartwheel.for_(replace(character, muscles=()))


def test_wrong_arguments_are_told_of() -> None:
    with pytest.raises(InputError, match="direction of Cartwheel must be 1 or -1"):
        Cartwheel(direction=0.5)
    with pytest.raises(InputError, match="feet of Cartwheel must be"):
        Cartwheel(feet=FEET[:2])
    with pytest.raises(InputError, match=r"CartwheelGains\.cruise must"):
        CartwheelGains(cruise=0.0)


def test_it_ends_so_that_another_motion_follows() -> None:
    turn = Cartwheel(replace(GAINS, rest_time=0.5), start=0.0)
    both = Sequence([Motion(controller=turn), Motion(controller=Balance.for_(scene().character))])
    simulation = Simulation(scene(), both, time_step=1.0 / 60.0, fps=60.0)
    for _ in simulation.run(6.0):
        pass
    assert turn.finished and [span.name for span in both.course] == ["cartwheel", "balance"]
    assert turn.phase == pytest.approx(2.0 * math.pi)
    assert np.isfinite(simulation.frame().positions).all()
