"""roll-o and roll-o-return, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.measures import turned
from tests.scenes.runs import Shipped, missed, run


def test_it_rolls_more_than_once_around(shipped: Shipped) -> None:
    motion = shipped("roll-o")
    assert missed("roll-o", motion) == []
    assert turned(motion.take, 1)[-1] == pytest.approx(390.0, abs=4.0)
    angle, way = turned(motion.take, 1)[-1], motion.measures.centre_of_mass[-1, 0]
    assert angle > 360.0
    # no slipping on the spot: the way is that of the rim, to a fifth
    assert abs(way - np.radians(angle) * 0.5) < 0.2 * way


def test_it_stops_and_rolls_back(shipped: Shipped) -> None:
    motion = shipped("roll-o-return")
    assert missed("roll-o-return", motion) == []
    angle = turned(motion.take, 1)
    assert angle.max() == pytest.approx(220.0, abs=4.0)
    assert angle[-1] == pytest.approx(0.0, abs=6.0)


@pytest.mark.parametrize(
    "options",
    [("--time-step", "0.0083334"), ("--newton-iterations", "2"), ("--elements", "linear")],
    ids=["half the step", "two iterations", "linear elements"],
)
def test_it_stops_at_the_same_angle_however_it_is_computed(
    options: tuple[str, str], tmp_path: Path
) -> None:
    motion = run("roll-o", tmp_path, *options)
    assert missed("roll-o", motion) == []
    assert turned(motion.take, 1)[-1] == pytest.approx(390.0, abs=4.0)


def test_limp_it_stays_where_it_stands(tmp_path: Path) -> None:
    motion = run("roll-o", tmp_path, "--controller", "none", "--seconds", "3")
    assert np.abs(turned(motion.take, 1)).max() < 5.0
