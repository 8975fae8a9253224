"""leap-i, measured from its stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.measures import leaps
from tests.scenes.runs import Shipped, missed, run

SCENE = "leap-i"
FROM_A_STAND = 0.09
"""m, how far `jump-i` goes in each of its hops."""


def test_it_leaps_and_stands(shipped: Shipped) -> None:
    motion = shipped(SCENE)
    assert missed(SCENE, motion) == []
    assert max(leaps(motion.take)) > 2.5 * FROM_A_STAND
    path = motion.measures.centre_of_mass
    assert path[-1, 0] - path[0, 0] > max(leaps(motion.take)) - 0.05


def test_the_hops_of_the_letter_that_jumps_from_a_stand_are_shorter(shipped: Shipped) -> None:
    """Measured alike."""
    assert max(leaps(shipped("jump-i").take)) == pytest.approx(FROM_A_STAND, abs=0.02)


@pytest.mark.parametrize(
    "options",
    [
        ("--time-step", "0.0333333"),
        ("--time-step", "0.0083334"),
        ("--newton-iterations", "2"),
        ("--elements", "linear"),
        ("--set", "push=0.2", "--seconds", "5"),
        ("--set", "friction=0.64"),
        ("--set", "leaps=3"),
    ],
    ids=[
        "twice the step",
        "half the step",
        "two iterations",
        "linear",
        "pushed",
        "smooth floor",
        "three",
    ],
)
def test_it_does_so_however_it_is_computed(options: tuple[str, ...], tmp_path: Path) -> None:
    assert missed(SCENE, run(SCENE, tmp_path, *options)) == []


def test_limp_it_stays_where_it_stands(tmp_path: Path) -> None:
    motion = run(SCENE, tmp_path, "--controller", "none", "--seconds", "1.5")
    path = motion.measures.centre_of_mass
    assert leaps(motion.take) == []
    assert np.abs(path - path[0])[:, :2].max() < 1e-3
