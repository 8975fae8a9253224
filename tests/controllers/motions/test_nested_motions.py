"""Controllers within controllers: whose they are, what they are told, and how runs tell of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.noted_controllers import BAR, DT, Ending, Noted, shown, view_at
from warp_softbody import Batch, Body, Plane, Scene, Simulation, placed
from warp_softbody.controllers import Combined, Controller, Motion, Sequence
from warp_softbody.controllers.inner_controllers import two_with_one, with_inner
from warp_softbody.errors import InputError
from warp_softbody.world.view import BodyView

SCENE = Scene(character=BAR, ground=Plane())


class Told(Noted):
    """Notes where the body was as it was told that its motion begins."""

    def __init__(self) -> None:
        """Told of nothing yet."""
        super().__init__()
        self.begun: list[tuple[float, float, float]] = []

    def begin(self, view: BodyView, standing: BodyView) -> None:
        """Time, s, and heights, m, of the body and of that at rest."""
        height, at_rest = (float(own.center_of_mass[2]) for own in (view, standing))
        self.begun.append((view.time, height, at_rest))


def in_sequence(inner: Controller) -> Sequence:
    """It is followed by another one."""
    return Sequence([Motion(controller=inner, seconds=DT), Noted()])


def deep(inner: Controller) -> Sequence:
    """It lies three deep."""
    return Sequence([Combined([Noted(), in_sequence(inner)])])


def test_all_within_a_controller_are_found() -> None:
    inner = Noted()
    assert sum(own is inner for own in with_inner(deep(inner))) == 1
    assert len(list(with_inner(deep(inner)))) == 6
    assert two_with_one([[Noted()], [deep(inner)], [inner]]) == (1, 2)
    # a sequence takes copies of one that it has twice
    assert two_with_one([[Sequence([Motion(controller=inner, seconds=DT), inner])]]) is None

    class Own(Noted):
        controllers = (inner, "no controller")

    assert two_with_one([[Own()], [Combined([inner])]]) == (0, 1)


@pytest.mark.parametrize("around", [in_sequence, deep, lambda inner: Combined([Noted(), inner])])
def test_a_controller_in_two_places_is_refused(around: Any) -> None:
    inner = Noted()
    with pytest.raises(InputError, match="members 0 and 1 of a Batch have one controller"):
        Batch(SCENE, 2, lambda member: replace(member, controller=around(inner)))
    second = placed(BAR, name="second", translation=(3.0, 0.0, 0.0))
    two = replace(SCENE, others=(Body(character=second),))
    with pytest.raises(InputError, match="two bodies of a Simulation have one controller"):
        Simulation(two, around(inner), others={"second": inner})
    with pytest.raises(InputError, match="two of together of Combined have one controller"):
        Combined([around(inner), inner])
    Batch(SCENE, 2, lambda member: replace(member, controller=around(Noted())))


def test_a_sequence_takes_copies_of_what_lies_in_two_motions() -> None:
    inner = Ending()
    sequence = Sequence([Combined([inner]), Motion(controller=inner), Noted()], fade=0.0)
    shown(sequence, 8)
    assert [span.name for span in sequence.course] == ["combined", "ending", "noted"]
    assert inner.times == []


def test_the_first_motion_is_told_that_it_begins() -> None:
    first, beside, second, unaware = Told(), Told(), Told(), Noted()
    together = Combined([first, unaware, Combined([beside])])
    sequence = Sequence([Motion(controller=together, seconds=2 * DT), second], fade=0.0)
    own = view_at(0.4)
    squeezed = replace(own, positions=own.positions * [1.0, 1.0, 0.5])
    sequence.goals(squeezed)
    ((time, height, at_rest),) = first.begun
    assert time == 0.0
    assert at_rest == pytest.approx(2.0 * height, rel=1e-6)
    assert beside.begun == first.begun
    assert second.begun == []
    # what has no begin is asked of no step before the first
    assert unaware.times == [0.0]
    sequence.goals(view_at(0.4 + 2 * DT))
    assert len(first.begun) == len(second.begun) == 1


def test_a_sequence_within_tells_its_first_motion_of_the_body_as_it_is() -> None:
    first, inner, unaware = Told(), Told(), Noted()
    within = Sequence([Motion(controller=Combined([inner, unaware]), seconds=9.0)])
    sequence = Sequence([Motion(controller=Sequence([first]), seconds=DT), within], fade=0.0)
    sequence.goals(view_at(0.0))
    assert len(first.begun) == 1
    own = view_at(DT)
    sequence.goals(replace(own, positions=own.positions * [1.0, 1.0, 0.5]))
    ((time, height, at_rest),) = inner.begun
    assert time == 0.0
    assert at_rest == pytest.approx(2.0 * height, rel=1e-6)
    # at rest, and then of its first step
    assert unaware.heights == pytest.approx([at_rest, height])
    assert [span.name for span in sequence.course] == ["sequence: told", "sequence: combined"]


def test_courses_are_handed_through() -> None:
    inner = Sequence([Motion(controller=Noted(), seconds=2 * DT, name="one"), Noted()], fade=0.0)
    outer = Sequence(
        [
            Motion(controller=Noted(), seconds=3 * DT),
            Motion(controller=Combined([inner, Noted()]), seconds=4 * DT, name="both"),
            Noted(),
        ],
        fade=0.0,
    )
    simulation = Simulation(SCENE, Combined([outer, Noted()]), time_step=DT)
    for step in range(10):
        simulation.step()
        if step == 6:
            assert simulation.goal_report().motion == "both: noted"
    spans = simulation.summary().motions
    assert [own.name for own in spans] == ["noted", "both: one", "both: noted", "noted"]
    np.testing.assert_allclose([own.begun for own in spans], DT * np.array([0, 3, 5, 7]), atol=1e-9)
    ends = [own.ended for own in spans]
    assert ends.pop() is None
    assert ends == pytest.approx([3 * DT, 5 * DT, 7 * DT])


@pytest.mark.parametrize("answer", [1, None, "yes", np.float64(0.0)])
def test_an_end_is_told_by_true_or_false(answer: Any) -> None:
    motion = Motion(controller=Noted(), until=lambda view: answer)
    with pytest.raises(InputError, match=r"what Motion\.until returns must be True or False"):
        shown(Sequence([motion, Noted()]), 2)
    for attribute in ("finished", "interruptible"):
        own = Noted()
        setattr(own, attribute, answer)
        seconds = None if attribute == "finished" else DT
        sequence = Sequence([Motion(controller=own, seconds=seconds), Noted()])
        with pytest.raises(InputError, match=f"{attribute} of a Noted must be True or False"):
            shown(sequence, 3)


def test_an_end_may_be_numpy_s() -> None:
    def late(view: BodyView) -> Any:
        return np.bool_(view.time > 1.5 * DT)

    motion = Motion(controller=Noted(), until=late)
    own = Noted()
    own.finished = np.bool_(True)  # type: ignore[attr-defined]
    sequence = Sequence([motion, own, Noted()], fade=0.0)
    shown(sequence, 5)
    assert [span.begun for span in sequence.course] == pytest.approx([0.0, 2 * DT, 3 * DT])


def test_a_method_in_place_of_a_truth_value_is_refused_where_it_is_given() -> None:
    class Method(Noted):
        def finished(self) -> bool:
            return False

    with pytest.raises(InputError, match="finished of a Method must be True or False"):
        Sequence([Method(), Noted()])


def test_a_begin_that_takes_no_two_views_is_refused() -> None:
    class Short(Noted):
        def begin(self, view: BodyView) -> None:
            pass

    for compose in (lambda own: Motion(controller=own), lambda own: Combined([Noted(), own])):
        with pytest.raises(InputError, match="begin of a Short must be a function of two views"):
            compose(Short())
