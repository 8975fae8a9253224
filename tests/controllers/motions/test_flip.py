"""Somersaults: the course of activations, and the length in the air."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import Plane, Scene, Simulation
from warp_softbody.characters import letter_i
from warp_softbody.controllers import Flip, FlipGains, TakeOff
from warp_softbody.controllers.motions.flip import FlipPhase
from warp_softbody.controllers.motions.muscle_quarters import muscle_quarters
from warp_softbody.errors import InputError
from warp_softbody.scenes.flip_i import GAINS, TAKE_OFF, flipping_letter

GRAVITY = 9.81


def test_quarters_are_behind_and_ahead_below_and_above() -> None:
    letter = letter_i(coarse=2)
    view = Simulation(Scene(character=letter, ground=Plane())).view()
    # fibres of twelve segments, from below, at x -, +, -, +
    behind, ahead = [0] * 6 + [1] * 6, [2] * 6 + [3] * 6
    assert muscle_quarters(view).tolist() == behind + ahead + behind + ahead


def test_a_take_off_that_stays_down_ends_in_standing() -> None:
    weak = TakeOff(crouch=1.0, interval=0.1, levels=((0.98, 0.98, 0.98, 0.98),))
    gains = replace(GAINS, longest=0.5)
    controller = Flip(gains, take_off=weak, start=0.0)
    scene = Scene(character=flipping_letter(2.0), ground=Plane(friction=0.8))
    simulation = Simulation(scene, controller, time_step=1.0 / 120.0, fps=60.0)
    for _ in simulation.run(0.7):
        pass
    assert controller.phase is FlipPhase.LAND and controller.interruptible
    assert simulation.frame().positions[:, 2].mean() > 0.4


def test_a_stiffer_body_leaves_the_ground_otherwise_but_lands_at_the_same_angle() -> None:
    """The length in the air makes up for what the take-off misses."""
    touched = []
    for factor in (0.9, 1.0):
        letter = flipping_letter(2.0)
        modulus = factor * letter.material.young_modulus
        letter = replace(letter, material=replace(letter.material, young_modulus=modulus))
        controller = Flip(GAINS, take_off=TAKE_OFF)
        scene = Scene(character=letter, ground=Plane(friction=0.8))
        simulation = Simulation(scene, controller, time_step=1.0 / 240.0, fps=60.0)
        while controller.phase is not FlipPhase.ARREST and simulation.time < 2.2:
            simulation.step()
        touched.append(np.degrees(controller.angle))
    assert touched[0] == pytest.approx(touched[1], abs=4.0)
    assert touched[1] == pytest.approx(360.0 - np.degrees(GAINS.lean), abs=20.0)


@pytest.mark.parametrize("longest", [4.7, 0.5])
def test_it_balances_once_upright_or_after_the_longest_arrest(longest: float) -> None:
    """The ground has taken the spin long before the letter has come up."""
    gains = replace(GAINS, longest_arrest=longest)
    controller = Flip(gains, take_off=TAKE_OFF)
    scene = Scene(character=flipping_letter(2.0), ground=Plane(friction=0.8))
    simulation = Simulation(scene, controller, time_step=1.0 / 240.0, fps=60.0)
    while controller.phase is not FlipPhase.ARREST and simulation.time < 2.2:
        simulation.step()
    touched = simulation.time
    while controller.phase is FlipPhase.ARREST and simulation.time < 4.0:
        simulation.step()
    assert controller.phase is FlipPhase.LAND
    left = 2.0 * np.pi - controller.angle
    if longest > 1.0:
        assert abs(left) <= GAINS.upright
        assert simulation.time - touched > 2.0 * GAINS.arrest_time / np.sqrt(GRAVITY)
    else:
        assert left > 3.0 * GAINS.upright
        assert simulation.time - touched == pytest.approx(longest / np.sqrt(GRAVITY), abs=0.01)


def test_wrong_arguments_are_told_of() -> None:
    with pytest.raises(InputError, match=r"TakeOff.levels must be"):
        TakeOff(levels=((0.4, 0.5, 0.5, 0.5),))
    with pytest.raises(InputError, match=r"TakeOff.crouch must be"):
        TakeOff(crouch=0.0)
    with pytest.raises(InputError, match=r"FlipGains.least_length must be"):
        FlipGains(least_length=0.0)
    with pytest.raises(InputError, match=r"FlipGains.longest_arrest must be"):
        FlipGains(longest_arrest=-1.0)
    with pytest.raises(InputError, match="take_off of Flip must be"):
        Flip(take_off=GAINS)  # type: ignore[arg-type]


def test_segments_that_are_none_are_told_of() -> None:
    scene = Scene(character=letter_i(coarse=2), ground=Plane())
    simulation = Simulation(scene, Flip(start=0.0, resting=(3, 1000)), time_step=1.0 / 60.0)
    with pytest.raises(InputError, match=r"Goals.resting holds segment 1000, but there are 48"):
        for _ in range(3):
            simulation.step()
