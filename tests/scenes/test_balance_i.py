"""balance-i, measured from its stage: it stands, and recovers from a push that topples it limp."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warp_softbody.cli import main
from warp_softbody.stage_exports import measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures


def run(folder: Path, *options: str) -> Measures:
    """Measures of a run's stage, which has to be finite, valid, without inverted or sunken tets."""
    stage = folder / "i.usdc"
    assert main(["run", "balance-i", "--out", str(stage), "--quiet", *options]) == 0
    assert validate(stage) == []
    measures = measure(read_take(stage))
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert np.abs(measures.volume_change).max() < 0.15
    # for a body 1 m high, after the first half second
    assert measures.penetration[measures.times >= 0.5].max() < 0.002
    return measures


def test_it_stands_for_six_seconds(tmp_path: Path) -> None:
    measures = run(tmp_path, "--seconds", "6", "--set", "push=0")
    assert measures.tilt.max() < 10.0
    moved = measures.centre_of_mass[-1] - measures.centre_of_mass[0]
    assert np.linalg.norm(moved) < 0.02


@pytest.mark.parametrize("push", [0.3, 0.5])
def test_it_recovers_from_a_push(push: float, tmp_path: Path) -> None:
    """The base widens meanwhile, and part of it leaves the ground."""
    measures = run(tmp_path, "--seconds", "6", "--set", f"push={push}")
    assert measures.tilt.max() > 10.0
    assert measures.tilt[-1] < 5.0
    assert measures.base_area.max() > 1.05 * measures.base_area[0]


def test_without_muscles_the_push_topples_it(tmp_path: Path) -> None:
    options = ["--seconds", "3", "--set", "push=0.5", "--controller", "none"]
    measures = run(tmp_path, *options)
    assert measures.centre_of_mass[-1, 2] < 0.5 * measures.centre_of_mass[0, 2] + 0.1
    assert measures.tilt[-1] > 45.0
