"""Motions under controllers that were kept go on to the last bit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.support.bodies import muscular_bar
from warp_softbody import Body, Plane, Scene, Simulation, placed, scenes
from warp_softbody.controllers import Balance, Goals, Jump, Motion, Sequence, objectives
from warp_softbody.errors import InputError
from warp_softbody.scenes.balance_i import GAINS
from warp_softbody.world.frame import Frame
from warp_softbody.world.view import BodyView

Make = Callable[[], Simulation]


class Sway:
    """Wants a bar to go to and fro; remembers how often it was asked."""

    def __init__(self, force: float) -> None:
        """Push along x with a force, N, and every third step back."""
        self.force = force
        self.asked = 0

    def goals(self, view: BodyView) -> Goals:
        """A momentum whose rate hangs on the number of steps."""
        self.asked += 1
        rate = np.array([self.force if self.asked % 3 else -self.force, 0.0, self.force])
        return Goals(objectives=(objectives.linear_momentum(view, rate),))


class Slotted:
    """Remembers in a slot."""

    __slots__ = ("asked",)

    def goals(self, view: BodyView) -> None:
        """Want nothing."""


def shipped(name: str, **settings: float) -> Make:
    def make() -> Simulation:
        plan = scenes.make(name, settings)
        return Simulation(plan.scene, plan.controller, time_step=plan.time_step)

    return make


def bars() -> Simulation:
    """Two bars that rest on each other, each with a controller."""
    bar = muscular_bar()
    height = float(np.ptp(bar.mesh.points[:, 2]))
    upper = placed(bar, name="upper", translation=(0.0, 0.0, height + 0.002))
    scene = Scene(character=bar, others=(Body(character=upper),), ground=Plane(friction=0.8))
    return Simulation(scene, Sway(10.0), others={"upper": Sway(-5.0)}, time_step=0.01)


def in_sequence() -> Simulation:
    """A letter that goes over from some gains to others."""
    plan = scenes.make("balance-i", {"coarse": 1})
    motions = Sequence([Motion(controller=Balance(GAINS), seconds=0.3), Balance()])
    return Simulation(plan.scene, motions, time_step=plan.time_step)


def after(simulation: Simulation, steps: int) -> list[Frame]:
    found = []
    for _ in range(steps):
        simulation.step()
        found.append(simulation.frame())
    return found


@pytest.mark.parametrize(
    ("make", "steps"),
    [
        (shipped("balance-i", coarse=1), 35),
        (shipped("walk-x", coarse=1), 40),
        (shipped("jump-i-in-place", coarse=1), 30),
        (bars, 7),
        (in_sequence, 22),
    ],
    ids=["balance", "walk", "jump", "two bodies", "sequence"],
)
def test_goes_on_to_the_last_bit(make: Make, steps: int) -> None:
    """In the same simulation, which has gone on meanwhile, and in one that has just begun."""
    simulation = make()
    after(simulation, steps)
    saved = simulation.save()
    shown = simulation.frame()
    once = after(simulation, 10)
    after(simulation, 3)
    for other in (simulation, make()):
        other.restore(saved)
        again = [other.frame(), *after(other, 10)]
        for one, two in zip([shown, *once], again, strict=True):
            for name in ("positions", "velocities", "activations"):
                np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
            np.testing.assert_array_equal(one.contacts.forces, two.contacts.forces)
            np.testing.assert_array_equal(one.patches.forces, two.patches.forces)


def test_a_motion_can_be_taken_up_again_and_again() -> None:
    """What is restored does not change what was saved."""
    simulation = bars()
    after(simulation, 4)
    saved = simulation.save()
    ends = []
    for _ in range(3):
        simulation.restore(saved)
        ends.append(after(simulation, 5)[-1].positions)
    np.testing.assert_array_equal(ends[0], ends[1])
    np.testing.assert_array_equal(ends[0], ends[2])


def test_what_cannot_be_kept_or_taken_up() -> None:
    plan = scenes.make("balance-i", {"coarse": 1})

    def under(controller: object) -> Simulation:
        return Simulation(plan.scene, controller, time_step=plan.time_step)  # type: ignore[arg-type]

    with pytest.raises(InputError, match="save: a Slotted has slots"):
        under(Slotted()).save()
    balanced = under(Balance()).save()
    with pytest.raises(InputError, match="with a Balance for 'letter_i' cannot be restored by a"):
        under(Jump()).restore(balanced)
    stubborn = Balance()
    stubborn.generator = (k for k in range(3))  # type: ignore[attr-defined]
    with pytest.raises(InputError, match="save: what a Balance remembers cannot be copied"):
        under(stubborn).save()
