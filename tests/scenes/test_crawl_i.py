"""crawl-i and crawl-i-inchworm, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.criteria import arches, belly, ways
from tests.scenes.runs import Shipped, missed, run
from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.characters import letter_i_flat
from warp_softbody.controllers.controller import Goals
from warp_softbody.controllers.motions.crawl import Crawl, CrawlGains, CrawlPhase
from warp_softbody.stage_exports.usd.reader import Take
from warp_softbody.world.scene import STANDARD_GRAVITY
from warp_softbody.world.view import BodyView

LENGTH = 1.0  # m, of the body
START, CYCLE, CYCLES = 0.5, 1.2, 10  # s, s


def pull(take: Take, name: str) -> float:
    """Largest l / l_0 - l_d / l_0 of the strands with a text in their names: their tension / S."""
    ends = take.fiber_points
    length = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    chosen = [name in f.name for f in letter_i_flat().fibers for _ in range(f.segment_count)]
    # The activations of a frame were chosen for the lengths of the frame before.
    tension = length[:-1] / length[0] - take.activations[1:]
    return float(np.maximum(tension, 0.0)[:, chosen].max())


def test_the_earthworm_crawls_its_length_on_its_belly(shipped: Shipped) -> None:
    motion = shipped("crawl-i")
    assert motion.take.times[-1] == pytest.approx(START + CYCLES * CYCLE)
    assert missed("crawl-i", motion) == []
    assert belly(motion) < 0.05 * LENGTH


def test_the_inchworm_crawls_by_arching(shipped: Shipped) -> None:
    motion = shipped("crawl-i-inchworm")
    assert missed("crawl-i-inchworm", motion) == []
    assert len(arches(motion)) == CYCLES
    # Upper strands have next to nothing to do with it.
    assert pull(motion.take, "upper") < 0.3 * pull(motion.take, "lower")


@pytest.mark.long
@pytest.mark.parametrize("friction", ["0.16", "0.24"])
def test_they_crawl_on_other_floors(friction: str, tmp_path: Path) -> None:
    for scene in ("crawl-i", "crawl-i-inchworm"):
        motion = run(scene, tmp_path, "--set", f"friction={friction}")
        assert missed(scene, motion) == []


def test_with_static_contacts_the_earthworm_stays(tmp_path: Path) -> None:
    """Contacts that hold still let no end move, so nothing is worth contracting for."""
    options = ("--controller", "static", "--seconds", "4.1")
    motion = run("crawl-i", tmp_path, *options)
    assert abs(ways(motion)[0][-1]) < 0.05 * 3 * 0.145


def test_limp_they_stay_where_they_lie(tmp_path: Path) -> None:
    for scene in ("crawl-i", "crawl-i-inchworm"):
        take = run(scene, tmp_path, "--controller", "none", "--seconds", "1").take
        assert np.abs(take.tet_points - take.tet_points[0]).max() < 0.01


def test_a_push_slides_them_forward_and_not_back(tmp_path: Path) -> None:
    force, friction, lasts = 0.4, 0.2, 0.3  # body weights, of the floor, s
    reached = []
    for push in (force, -force):
        settings = ("--set", f"push={push}", "--set", f"push_seconds={lasts}")
        motion = run("crawl-i", tmp_path, "--controller", "none", "--seconds", "2", *settings)
        reached.append(float(motion.measures.centre_of_mass[-1, 0]))
    # A rigid block: F - mu m g speeds it up, mu m g stops it. A soft one goes less far, as its
    # shaking takes energy; backward, the force is a fifth of the friction that it would take.
    speed = (force - friction) * STANDARD_GRAVITY * lasts
    rigid = 0.5 * speed * lasts + speed**2 / (2.0 * friction * STANDARD_GRAVITY)
    assert 0.5 * rigid < reached[0] < rigid
    assert abs(reached[1]) < 0.01 * rigid


def view_at(time: float, *, tail: float = 0.0, speed: float = 0.0) -> BodyView:
    """The crawler as it lies at rest, but for its tail so many m ahead and a speed along x, m/s."""
    scene = scenes.make("crawl-i").scene
    mesh = scene.character.mesh
    positions = np.array(mesh.points)
    positions[scene.character.region("tail"), 0] += tail
    return BodyView(
        scene=scene,
        time=time,
        time_step=1.0 / 60.0,
        masses=np.ones(len(positions)),
        positions=positions,
        velocities=np.full_like(positions, (speed, 0.0, 0.0)),
        touching=mesh.points[:, 2] < 1e-6,
        activations=np.ones(scene.character.segment_count),
    )


TAIL, HEAD = slice(0, 2), slice(2, 4)


UNIT = 9.81**-0.5
"""s, of time for a letter of a metre."""


def wanted(goals: Goals) -> FloatArray:
    """Velocities of the four corners, (4, 3) m/s."""
    return np.asarray([corner.target / UNIT for corner in goals.objectives[:4]])


def test_one_end_holds_while_the_other_goes_ahead() -> None:
    crawl = Crawl(
        CrawlGains(stride=0.1, pull_time=0.4 / UNIT, push_time=0.8 / UNIT, follow=10.0 * UNIT),
        start=0.5 / UNIT,
    )
    # Half way a step of the fifth degree, at rest and without acceleration at its ends, is steepest
    # with 15/8 of its way in its time, and an end that is still at rest is behind by half of it.
    crawl.goals(view_at(0.0))
    pull = crawl.goals(view_at(0.7))
    pulled = crawl.phase
    np.testing.assert_allclose(wanted(pull)[TAIL, 0], 0.1 * 1.875 / 0.4 + 10.0 * 0.05, atol=1e-12)
    np.testing.assert_allclose(wanted(pull)[HEAD], 0.0, atol=1e-12)
    crawl.goals(view_at(0.9, tail=0.06))
    push = crawl.goals(view_at(1.3, tail=0.06))
    assert (pulled, crawl.phase) == (CrawlPhase.PULL, CrawlPhase.PUSH)
    # The ends are 0.06 m nearer than at first, which is all that the head has to go.
    ahead = 0.06 * 1.875 / 0.8 + 10.0 * 0.03
    np.testing.assert_allclose(wanted(push)[HEAD, 0], ahead, atol=1e-12)
    np.testing.assert_allclose(wanted(push)[TAIL], 0.0, atol=1e-12)
    for goals, slippery in ((pull, 0), (push, 5)):
        np.testing.assert_allclose(goals.objectives[-1].target, 0.0, atol=1e-12)
        assert len(goals.patches) == 6
        assert [i for i, p in enumerate(goals.patches) if p.slips] == [slippery]


@pytest.mark.parametrize("arch", [0.0, 0.2])
def test_ends_and_middle_go_on_as_fast_as_they_are(arch: float) -> None:
    """Wherever they are when a phase begins: a jump of what is wanted would shake the body."""
    gains = CrawlGains(stride=0.1, arch=arch, pull_time=0.4 / UNIT, push_time=0.8 / UNIT)
    crawl = Crawl(gains, start=0.5 / UNIT)
    crawl.goals(view_at(0.0))
    for time, moving, phase in ((0.5, TAIL, CrawlPhase.PULL), (0.9, HEAD, CrawlPhase.PUSH)):
        begun = crawl.goals(view_at(time, tail=0.02, speed=0.3))
        assert crawl.phase is phase
        np.testing.assert_allclose(wanted(begun)[moving, 0], 0.3, atol=1e-12)
        np.testing.assert_allclose(begun.objectives[-1].target, 0.0, atol=1e-12)


def test_an_end_that_is_not_held_to_its_place_is_only_to_come_to_rest() -> None:
    crawl = Crawl(CrawlGains(pull_time=0.4 / UNIT, hold=0.0), start=0.5 / UNIT)
    for time in (0.0, 0.5, 0.9):
        push = crawl.goals(view_at(time, tail=0.06, speed=0.2))
    assert crawl.phase is CrawlPhase.PUSH
    np.testing.assert_allclose(wanted(push)[TAIL, 0], 0.0, atol=1e-12)


def test_an_end_that_is_to_hold_comes_gently_to_a_stop() -> None:
    """The velocity wanted of it is its own at first, and then falls with its distance to go."""
    gains = CrawlGains(pull_time=0.4 / UNIT, follow=10.0 * UNIT, hold=10.0 * UNIT)
    crawl = Crawl(gains, start=0.5 / UNIT)
    crawl.goals(view_at(0.0))
    crawl.goals(view_at(0.5))
    push = crawl.goals(view_at(0.9, tail=0.06, speed=0.2))
    np.testing.assert_allclose(wanted(push)[TAIL, 0], 0.2, atol=1e-12)
    later = crawl.goals(view_at(1.0, tail=0.065))
    np.testing.assert_allclose(wanted(later)[TAIL, 0], 0.2 - 10.0 * 0.005, atol=1e-12)


def test_a_tail_that_is_behind_its_schedule_is_pulled_further() -> None:
    """By at most two fifths of a stride: here nothing has moved, so a whole stride is missing."""
    gains = CrawlGains(stride=0.1, pull_time=0.4 / UNIT, push_time=0.8 / UNIT, follow=10.0 * UNIT)
    crawl = Crawl(gains, start=0.5 / UNIT)
    for time in (0.0, 0.5, 0.9, 1.7):
        crawl.goals(view_at(time))
    pull = crawl.goals(view_at(1.9))
    assert crawl.phase is CrawlPhase.PULL
    expected = 0.14 * 1.875 / 0.4 + 10.0 * 0.07
    np.testing.assert_allclose(wanted(pull)[TAIL, 0], expected, atol=1e-12)
