"""flip-i, measured from its stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.measures import flights, flipped_in_air, turned
from benchmarks.perturbed_starts import PUSH, PerturbedStart, outcome
from tests.scenes.runs import Shipped, missed, run
from warp_softbody import scenes

SCENE = "flip-i"
GRAVITY = 9.81


def test_it_turns_a_somersault_and_stands(shipped: Shipped) -> None:
    motion = shipped(SCENE)
    assert missed(SCENE, motion) == []
    assert flipped_in_air(motion.take) > 300.0
    assert turned(motion.take, 1)[-1] == pytest.approx(360.0, abs=2.0)
    assert max(flights(motion.take)) > 0.8


def test_in_the_air_only_gravity_acts(shipped: Shipped) -> None:
    """The centre of mass is on a parabola, and angular momentum stays, whatever muscles do."""
    motion = shipped(SCENE)
    take = motion.take
    heights = take.tet_points[:, :, 2].min(axis=1)
    high = np.flatnonzero(heights > 0.05)
    high = high[: np.flatnonzero(np.diff(np.r_[high, high[-1] + 9]) > 1)[0] + 1][2:-2]
    middle, times = motion.measures.centre_of_mass[high], motion.measures.times[high]
    assert len(high) > 40
    fall = np.polyfit(times, middle[:, 2], 2)
    assert -2.0 * fall[0] == pytest.approx(GRAVITY, rel=0.01)
    assert np.ptp(np.gradient(middle[:, 0], times)) < 0.01


@pytest.mark.long
@pytest.mark.parametrize(
    "options",
    [
        ("--newton-iterations", "2"),
        ("--elements", "linear"),
        ("--tangent", "warped"),
        ("--time-step", str(1.0 / 480.0)),
    ],
    ids=["two iterations", "linear elements", "warped tangent", "half the step"],
)
def test_it_does_so_however_it_is_computed(options: tuple[str, str], tmp_path: Path) -> None:
    assert missed(SCENE, run(SCENE, tmp_path, *options)) == []


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 1, 2, 8, 11])
def test_it_survives_perturbed_starts(number: int, tmp_path: Path) -> None:
    start = PerturbedStart.of(number, scenes.recipe(SCENE).seconds, PUSH)
    assert outcome(SCENE, start.plan(SCENE, {}, 0), tmp_path / "motion.usdc").failures == []


def test_limp_it_stays_where_it_stands(tmp_path: Path) -> None:
    motion = run(SCENE, tmp_path, "--controller", "none", "--seconds", "1")
    assert np.abs(turned(motion.take, 1)).max() < 5.0
