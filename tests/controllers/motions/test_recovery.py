"""What a body can tell of a push, and when it leaves its base, for motions with known answers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import Plane, Scene, Simulation, scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.characters import letter_i, letter_t
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.balance_gains import ANY_BODY, LETTER
from warp_softbody.controllers.motions.outer_push import OuterPush
from warp_softbody.controllers.motions.recovery import Recovery, RecoveryPhase, Tipping
from warp_softbody.controllers.motions.recovery_gains import RecoveryGains
from warp_softbody.scenes.pushes import head_push
from warp_softbody.world.view import BodyView

SCENE = Scene(character=letter_i())
COUNT = len(SCENE.character.mesh.points)
STEP = 1.0 / 60.0  # s
MASS, G = 2.0, 9.81
SOLE = np.array([[-0.25, -0.15], [0.25, -0.15], [0.25, 0.15], [-0.25, 0.15]])
PATCHES = ("base_patch_0", "base_patch_1", "base_patch_2", "base_patch_3")


def seen(time: float, speed: FloatArray, ground: FloatArray, *, touches: bool = True) -> BodyView:
    """A body whose nodes all move alike, after a step in which the ground gave it an impulse."""
    return BodyView(
        scene=SCENE,
        time=time,
        time_step=STEP,
        masses=np.full(COUNT, MASS / COUNT),
        positions=SCENE.character.mesh.points,
        velocities=np.tile(speed, (COUNT, 1)),
        touching=np.full(COUNT, touches),
        activations=np.ones(0),
        impulses=np.tile(ground / COUNT, (COUNT, 1)),
    )


def test_a_push_is_what_the_ground_does_not_account_for() -> None:
    push, friction = np.array([3.0, -2.0, 0.0]), np.array([-0.4, 0.1, MASS * G * STEP])
    outer, speed = OuterPush(), np.array([0.1, 0.0, 0.0])
    outer.see(seen(0.0, speed, friction))
    assert outer.lasted == 0.0 and not outer.acceleration.any()
    for number in (1, 2):
        speed = speed + STEP * push + friction * [1.0, 1.0, 0.0] / MASS
        outer.see(seen(number * STEP, speed, friction))
        np.testing.assert_allclose(outer.acceleration, push[:2], rtol=1e-12)
        assert outer.lasted == pytest.approx(number * STEP)


def test_friction_alone_is_no_push() -> None:
    friction, speed = np.array([-0.4, 0.1, 0.0]), np.zeros(3)
    outer = OuterPush()
    for number in range(3):
        outer.see(seen(number * STEP, speed + number * friction / MASS, friction))
        assert outer.lasted == 0.0 and not outer.acceleration.any()


def test_views_that_do_not_follow_one_another_tell_of_no_push() -> None:
    outer = OuterPush()
    outer.see(seen(0.0, np.zeros(3), np.zeros(3)))
    outer.see(seen(0.5, np.array([1.0, 0.0, 0.0]), np.zeros(3)))
    assert outer.lasted == 0.0 and not outer.acceleration.any()


def test_the_capture_point_is_carried_as_by_an_even_acceleration() -> None:
    """From c + v sqrt(h / g) to c + v t + a t^2 / 2 + (v + a t) sqrt(h / g)."""
    outer, a = OuterPush(), np.array([4.0, 1.0])
    outer.acceleration = a
    place, speed, fall, t = np.array([0.1, -0.2]), np.array([0.5, 0.3]), 0.22, 0.15
    later = place + speed * t + 0.5 * a * t**2 + (speed + a * t) * fall
    found = outer.carried(place + speed * fall, speed, fall, t)
    np.testing.assert_allclose(found, later, rtol=1e-12)


def falling(way: tuple[float, float], speed: tuple[float, float] = (0.0, 0.0)) -> Tipping:
    return Tipping(ahead=np.array(way), speed=np.array(speed), fall=0.22, sole=SOLE, height=1.0)


@pytest.mark.parametrize(("way", "share"), [((0.2, 0.0), 0.8), ((0.0, -0.3), 2.0), ((0.5, 0.3), 2)])
def test_a_way_counts_by_that_to_the_edge(way: tuple[float, float], share: float) -> None:
    assert falling(way).share(np.array(way)) == pytest.approx(share)


def recovered(way: tuple[float, float], speed: tuple[float, float]) -> Recovery:
    gains = in_si(LETTER.recovery, BodyUnits.of_scene(SCENE))
    recovery = Recovery("base", "head", PATCHES)
    recovery.goals(seen(0.0, np.zeros(3), np.zeros(3)), gains, falling(way, speed))
    return recovery


def test_the_base_is_left_where_the_capture_point_will_leave_it() -> None:
    """By a share of the way to the edge, as far as it moves in `RecoveryGains.still` besides."""
    gains = in_si(LETTER.recovery, BodyUnits.of_scene(SCENE))
    for narrow in (0.25, 0.15):
        side = np.array([1.0, 0.0]) if narrow == 0.25 else np.array([0.0, 1.0])
        for share, phase in ((0.98, RecoveryPhase.STAND), (1.02, RecoveryPhase.BRACE)):
            carried = share * gains.leave * narrow
            way, speed = 0.5 * carried * side, 0.5 * carried / gains.still * side
            found = recovered((way[0], way[1]), (speed[0], speed[1]))
            assert found.phase is phase


def test_a_body_that_lies_does_not_hop() -> None:
    gains = in_si(LETTER.recovery, BodyUnits.of_scene(SCENE))
    recovery = Recovery("base", "head", PATCHES)
    lying = replace(falling((0.8, 0.0)), height=0.5)
    assert recovery.goals(seen(0.0, np.zeros(3), np.zeros(3)), gains, lying) is None


def run(push: float, gains: RecoveryGains, seconds: float) -> tuple[FloatArray, Balance]:
    """Positions at the end, and the controller."""
    plan = scenes.make("balance-i", {"push": push})
    balance = Balance(replace(LETTER, recovery=gains))
    frames = Simulation(plan.scene, balance, fps=60).run(seconds)
    for frame in frames:
        last = frame
    return np.asarray(last.positions), balance


def test_a_push_that_is_borne_on_the_base_is_borne_as_without_hops() -> None:
    """To the last bit."""
    hops, one = run(0.5, LETTER.recovery, 1.5)
    none, _ = run(0.5, RecoveryGains(), 1.5)
    assert one.interruptible
    np.testing.assert_array_equal(hops, none)


def test_it_is_not_to_be_interrupted_while_it_hops() -> None:
    _, balance = run(0.65, LETTER.recovery, 0.9)
    assert not balance.interruptible


@pytest.mark.parametrize("push", [0.5, -0.5])
def test_another_body_hops_by_the_same_gains(push: float) -> None:
    """Letter T, softer and heavier above, falls where it is to stay on its base."""
    letter = letter_t()
    scene = Scene(
        character=letter,
        ground=Plane(friction=0.8),
        pushes=head_push(letter, {"push": push, "push_seconds": 0.2}),
    )
    heights = []
    for leave in (0.0, LETTER.recovery.leave):
        gains = replace(ANY_BODY, recovery=RecoveryGains(leave=leave))
        balance = Balance.for_(letter, gains)
        for frame in Simulation(scene, balance, time_step=STEP).run(3.0):
            last = frame
        heights.append(float(np.asarray(last.positions)[:, 2].max()))
    assert heights[0] < 0.7 * letter.mesh.points[:, 2].max()
    assert heights[1] > 0.95 * letter.mesh.points[:, 2].max()
