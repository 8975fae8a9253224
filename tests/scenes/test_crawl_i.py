"""crawl-i and crawl-i-inchworm, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motion_criteria import arches, belly, ways
from tests.scenes.runs import missed, run
from warp_softbody import scenes
from warp_softbody.characters import letter_i_flat
from warp_softbody.controllers.crawl import Crawl, CrawlGains, CrawlPhase
from warp_softbody.scene import STANDARD_GRAVITY
from warp_softbody.stage_exports.reader import Take
from warp_softbody.view import BodyView

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


def test_the_earthworm_crawls_its_length_on_its_belly(tmp_path: Path) -> None:
    motion = run("crawl-i", tmp_path)
    assert motion.take.times[-1] == pytest.approx(START + CYCLES * CYCLE)
    assert missed("crawl-i", motion) == []
    assert belly(motion) < 0.05 * LENGTH


def test_the_inchworm_crawls_by_arching(tmp_path: Path) -> None:
    motion = run("crawl-i-inchworm", tmp_path)
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


def view_at(time: float) -> BodyView:
    """The crawler as it lies at rest."""
    scene = scenes.make("crawl-i").scene
    mesh = scene.character.mesh
    count = len(mesh.points)
    return BodyView(
        scene=scene,
        time=time,
        time_step=1.0 / 60.0,
        masses=np.ones(count),
        positions=np.array(mesh.points),
        velocities=np.zeros((count, 3)),
        touching=mesh.points[:, 2] < 1e-6,
        activations=np.ones(scene.character.segment_count),
    )


def test_one_end_holds_while_the_other_goes_ahead() -> None:
    gains = CrawlGains(stride=0.1, pull_time=0.4, push_time=0.8)
    crawl = Crawl(gains, start=0.5)
    tail, head = slice(0, 2), slice(2, 4)
    # The steepest rate of a smooth step is 1.5 ways in its time; at rest nothing is off its place,
    # so half way the ends are behind by half a stride.
    cases = {
        0.0: (CrawlPhase.REST, 0.0, 0.0),
        0.7: (CrawlPhase.PULL, 0.1 * 1.5 / 0.4 + 10.0 * 0.05, 0.0),
        1.3: (CrawlPhase.PUSH, 0.0, 0.1 * 1.5 / 0.8 - 10.0 * 0.05),
    }
    for time, (phase, of_tail, of_head) in cases.items():
        if phase is CrawlPhase.PUSH:
            crawl.goals(view_at(0.9))
        goals = crawl.goals(view_at(time))
        assert crawl.phase is phase
        *corners, middle = goals.objectives
        targets = np.array([corner.target for corner in corners])
        np.testing.assert_allclose(targets[tail, 0], of_tail, atol=1e-12)
        np.testing.assert_allclose(targets[head, 0], of_head, atol=1e-12)
        np.testing.assert_allclose(targets[:, 1:], 0.0, atol=1e-12)
        np.testing.assert_allclose(middle.target, 0.0, atol=1e-12)
        assert len(goals.patches) == 6
