"""Motions in sequence and at once: when each begins and ends, and what is asked meanwhile."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.noted_controllers import BAR, DT, Ending, Noted, shown, view_at
from warp_softbody import Plane, Scene, Simulation
from warp_softbody.controllers import (
    Balance,
    Combined,
    Controller,
    Exercise,
    Gesture,
    Jump,
    Leg,
    Motion,
    Objective,
    Roll,
    Sequence,
    Sway,
    objectives,
)
from warp_softbody.controllers.motions.composition import faded
from warp_softbody.controllers.motions.standing_view import standing_view
from warp_softbody.controllers.motions.tracking import MissingRate
from warp_softbody.errors import InputError
from warp_softbody.scenes import roll_o
from warp_softbody.world.view import BodyView


def test_each_motion_has_its_own_time() -> None:
    one, two = Noted(), Noted()
    sequence = Sequence([Motion(controller=one, seconds=3 * DT), two], fade=0.0)
    shown(sequence, 6)
    assert one.times == pytest.approx([0.0, DT, 2 * DT])
    # asked once of the body at rest, and then step by step
    assert two.times == pytest.approx([0.0, 0.0, DT, 2 * DT])
    first, second = sequence.course
    assert (first.name, second.name) == ("noted", "noted")
    assert first.ended == second.begun == pytest.approx(3 * DT)
    assert second.ended is None
    assert not sequence.finished


def test_a_motion_ends_by_its_way_its_function_or_itself() -> None:
    for motion, steps in (
        (Motion(controller=Noted(), distance=0.25), 3),
        (Motion(controller=Noted(), until=lambda view: view.time > 3.5 * DT), 4),
        (Motion(controller=Noted(), until=lambda view: True, seconds=9.0), 1),
        (Motion(controller=Ending()), 2),
    ):
        sequence = Sequence([motion, Noted()], fade=0.0)
        shown(sequence, 8, lambda k: 0.1 * k)
        assert sequence.course[1].begun == pytest.approx(steps * DT)


def test_a_motion_is_ended_where_it_can_be_interrupted() -> None:
    airborne = Noted()
    airborne.interruptible = False
    sequence = Sequence([Motion(controller=airborne, seconds=DT), Noted()], fade=0.0)
    shown(sequence, 4)
    assert len(sequence.course) == 1
    airborne.interruptible = True
    sequence.goals(view_at(4 * DT))
    assert sequence.course[-1].begun == pytest.approx(4 * DT)


def test_it_does_not_wait_for_ever() -> None:
    airborne = Noted()
    airborne.interruptible = False
    sequence = Sequence([Motion(controller=airborne, seconds=DT), Noted()])
    for time in (0.0, DT, 60.0):
        sequence.goals(view_at(time))
    assert len(sequence.course) == 2


def test_rounds_begin_anew() -> None:
    one, two = Ending(), Motion(controller=Noted(), seconds=DT, name="second")
    sequence = Sequence([one, two], rounds=2, fade=0.0)
    shown(sequence, 12)
    assert [span.name for span in sequence.course] == ["ending", "second"] * 2
    assert sequence.finished
    # copies took part
    assert one.times == []


def test_the_last_motion_may_end_too() -> None:
    sequence = Sequence([Motion(controller=Noted(), seconds=2 * DT)])
    shown(sequence, 2)
    assert not sequence.finished
    sequence.goals(view_at(2 * DT))
    assert sequence.finished
    # so that it can stand in another one
    assert Motion(controller=sequence).ends


def test_objectives_fade_into_each_other() -> None:
    one, two = (Noted(rate).goals(view_at(0.0)) for rate in (0.0, 1.0))
    half = faded(one, two, 0.25)
    assert half is not None
    old, new = half.objectives
    np.testing.assert_allclose(old.weight, 0.75 * one.objectives[0].weight)
    np.testing.assert_allclose(new.weight, 0.25 * two.objectives[0].weight)
    assert half.activation.effort == pytest.approx(1.25)
    assert faded(one, two, 1.0) is two
    assert faded(None, two, 0.3) is two
    out = faded(one, None, 0.3)
    assert out is not None
    np.testing.assert_allclose(out.objectives[0].weight, 0.7)


def test_a_fade_lasts_its_time() -> None:
    length = float(np.ptp(BAR.mesh.bounds, axis=0).max())
    fade = 4.5 * DT / np.sqrt(length / 9.81)
    motions: list[Motion | Controller] = [Motion(controller=Noted(), seconds=2 * DT), Noted(1.0)]
    goals = shown(Sequence(motions, fade=fade), 9)
    assert [len(own.objectives) for own in goals] == [1, 1, 1, 2, 2, 2, 2, 1, 1]
    usual, dearer = goals[-1].activation.change, goals[2].activation.change
    assert dearer == pytest.approx(5.0 * usual)


def test_a_body_at_rest_where_it_is() -> None:
    own = view_at(0.3, shift=0.7)
    fallen = replace(own, positions=own.positions - [0.0, 0.0, 0.01], velocities=own.positions)
    rest = standing_view(fallen)
    np.testing.assert_allclose(
        rest.positions, BAR.mesh.points + np.array([0.7, 0.0, 0.0]), atol=1e-6
    )
    assert rest.time == 0.0
    assert not rest.velocities.any()
    sloped = Plane(normal=(0.0, -0.6, 0.8), offset=0.1)
    scene = Scene(character=BAR, ground=sloped)
    on_slope = standing_view(replace(fallen, scene=scene))
    gaps, _ = sloped.measure(on_slope.positions)
    assert abs(gaps.min()) < 1e-9


def test_heights_are_those_of_the_body_at_rest() -> None:
    one, two = Noted(), Noted()
    sequence = Sequence([Motion(controller=one, seconds=DT), two])
    sequence.goals(view_at(0.0))
    bent = view_at(DT)
    squeezed = replace(bent, positions=bent.positions * [1.0, 1.0, 0.5])
    sequence.goals(squeezed)
    at_rest, now = two.heights
    assert at_rest == pytest.approx(2.0 * now, rel=1e-6)


def test_a_second_roll_counts_from_where_the_first_one_ended() -> None:
    body = roll_o.rolling_letter(coarse=1)
    own = Simulation(Scene(character=body, ground=Plane()), time_step=DT).view()
    turn = np.radians(200.0)
    arms = own.positions - own.center_of_mass
    cosine, sine = np.cos(turn), np.sin(turn)
    # about y, as rolling along x
    rolled = arms @ np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    turned = replace(own, positions=rolled + own.center_of_mass)
    back = Roll(roll_o.GAINS, legs=(Leg(direction=-1.0, turn=turn),), rim="rim")
    back.begin(turned, turned)
    assert back._end - back._angle == pytest.approx(-turn)


def test_what_a_plan_misses_is_learnt_from_steps_alone() -> None:
    missing = MissingRate(0.1)
    wanted = np.array([1.0, 0.0, 0.0])
    missing.made_up(view_at(0.0), wanted)
    moving = view_at(0.0)
    moving = replace(moving, velocities=np.ones_like(moving.velocities))
    np.testing.assert_allclose(missing.made_up(moving, wanted), wanted)


def test_combined_goals() -> None:
    view = view_at(0.0)
    first, second = Noted(0.5), Noted(1.0)

    def lift(own: BodyView) -> Objective:
        return objectives.velocity(own, own.masses / own.mass, np.array([0.0, 0.0, 1.0]))

    combined = Combined([first, second, lift], weights=(1.0, 0.25, 0.0))
    goals = combined.goals(view)
    assert goals is not None
    assert [float(own.weight[0]) for own in goals.objectives] == [1.0, 0.25]
    assert goals.activation.effort == 1.5
    goals = Combined([first, lambda own: [lift(own), lift(own)]]).goals(view)
    assert goals is not None
    assert len(goals.objectives) == 3


def test_what_cannot_be_composed_is_refused() -> None:
    with pytest.raises(InputError, match=r"motions\[0\] of Sequence \(balance\) never ends"):
        Sequence([Balance(), Balance()])
    with pytest.raises(InputError, match=r"motions\[1\] of Sequence \(balance\) never ends"):
        Sequence([Jump(), Balance()], rounds=2)
    with pytest.raises(InputError, match="must hold a motion"):
        Sequence([])
    with pytest.raises(InputError, match=r"motions\[0\] of Sequence must be an object with a"):
        Sequence([3])  # type: ignore[list-item]
    with pytest.raises(InputError, match=r"Motion.distance must be a positive number of m"):
        Motion(controller=Balance(), distance=0.0)
    for controller in (Balance(), Jump()):
        with pytest.raises(
            InputError, match=r"stays in its place, so that a way of 2 m never ends"
        ):
            Motion(controller=controller, distance=2.0)
        Motion(controller=controller, distance=2.0, seconds=3.0)
    with pytest.raises(InputError, match="must hold a controller at least"):
        Combined([])
    with pytest.raises(InputError, match="weights of Combined must be 1 numbers"):
        Combined([Balance()], weights=(1.0, 2.0))
    with pytest.raises(InputError, match=r"what a function in Combined returns"):
        Combined([Noted(), lambda view: 3]).goals(view_at(0.0))  # type: ignore[list-item,return-value]


def test_motions_that_end_by_themselves_say_so() -> None:
    path = Sway(periods=1.0, period=1.0, ease=0.5)
    for controller in (Exercise(path=path), Gesture(region="head", path=path)):
        assert Motion(controller=controller).ends
        assert not controller.finished
    assert not Motion(controller=Balance()).ends
    assert Motion(controller=Jump()).title == "jump"
