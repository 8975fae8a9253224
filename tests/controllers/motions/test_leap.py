"""Leaps: when the body leaves its base, and whither."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import Plane, Scene, Simulation
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import Leap
from warp_softbody.controllers.motions.leap import LeapPhase
from warp_softbody.scenes.balance_i import balancing_letter
from warp_softbody.scenes.leap_i import GAINS

STEP = 1.0 / 60.0  # s
SCENE = Scene(character=balancing_letter(), ground=Plane(friction=0.8))


def leapt(leap: Leap, seconds: float) -> tuple[FloatArray, list[LeapPhase]]:
    """Way (3,) m of the middle of the base, and the phases in their order."""
    base, phases = SCENE.character.region("base"), [leap.phase]
    simulation = Simulation(SCENE, leap, time_step=STEP, fps=1.0 / STEP)
    for frame in simulation.run(seconds):
        if leap.phase is not phases[-1]:
            phases.append(leap.phase)
        last = frame
    points = SCENE.character.mesh.points
    return np.asarray(last.positions)[base].mean(axis=0) - points[base].mean(axis=0), phases


def test_it_leans_bows_leaps_and_stands() -> None:
    leap = Leap(GAINS, start=0.0)
    assert leap.interruptible and not leap.finished
    way, phases = leapt(leap, 3.0)
    assert phases[0] is LeapPhase.STAND
    in_order = [LeapPhase.LEAN, LeapPhase.BOW, LeapPhase.LEAP, LeapPhase.LAND]
    assert [one for one in phases if one in in_order] == in_order
    assert way[0] > 0.2 and abs(way[1]) < 0.03
    assert leap.interruptible and leap.finished


def test_it_leaps_the_other_way_as_far() -> None:
    """The letter is its own mirror image."""
    (there, _), (back, _) = (
        leapt(Leap(GAINS, start=0.0, heading=angle), 2.5) for angle in (0.0, np.pi)
    )
    assert -back[0] == pytest.approx(there[0], rel=0.15)


def test_a_body_that_may_not_lean_bows_after_its_time() -> None:
    """A capture point that is never far enough ahead does not keep it waiting for ever."""
    gains = replace(GAINS, acceleration=0.0, lean_time=0.5)
    leap = Leap(gains, start=0.0)
    _, phases = leapt(leap, 0.5 * np.sqrt(1.0 / 9.81) + 2.0 * STEP)
    assert phases[-1] is LeapPhase.BOW
