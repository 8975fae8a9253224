"""jump-i and jump-i-in-place, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.measures import base_path, flights
from tests.scenes.runs import Shipped, missed, run


def test_it_jumps_forward_and_stays_up(shipped: Shipped) -> None:
    motion = shipped("jump-i")
    # upright at the end, two seconds after landing
    assert missed("jump-i", motion) == []
    path = base_path(motion.take)
    assert abs(path[-1, 1] - path[0, 1]) < 0.05


@pytest.mark.long
@pytest.mark.parametrize("scene", ["jump-i", "jump-i-in-place"])
@pytest.mark.parametrize("friction", [0.64, 0.96])
def test_it_jumps_and_lands_on_other_floors(scene: str, friction: float, tmp_path: Path) -> None:
    assert missed(scene, run(scene, tmp_path, "--set", f"friction={friction}")) == []


def test_it_jumps_in_place_three_times(shipped: Shipped) -> None:
    motion = shipped("jump-i-in-place")
    assert missed("jump-i-in-place", motion) == []
    assert len([length for length in flights(motion.take) if length >= 0.15]) == 3
    path = base_path(motion.take)
    assert np.linalg.norm((path - path[0])[:, :2], axis=1).max() < 0.05


def test_without_muscles_it_stays_on_the_floor(tmp_path: Path) -> None:
    motion = run("jump-i", tmp_path, "--controller", "none", "--seconds", "2")
    assert flights(motion.take) == []
