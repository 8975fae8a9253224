"""jump-i and jump-i-in-place, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from warp_softbody.cli import main
from warp_softbody.stage_exports import measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.reader import Take

FPS = 60.0


def run(scene: str, folder: Path, *options: str) -> tuple[Take, Measures]:
    """A run's stage, which has to be finite, valid, without inverted or sunken tets."""
    stage = folder / "jump.usdc"
    arguments = ["run", scene, "--out", str(stage), "--fps", f"{FPS:g}", "--quiet", *options]
    assert main(arguments) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert np.abs(measures.volume_change).max() < 0.15
    assert measures.penetration.max() < 0.002
    return take, measures


def flights(take: Take) -> list[float]:
    """Lengths in s of the times with every node at least a millimetre above the floor."""
    lowest = take.tet_points[:, :, 2].min(axis=1)
    airborne = np.concatenate([[False], lowest > 1e-3, [False]]).astype(int)
    begins, ends = np.flatnonzero(np.diff(airborne) == 1), np.flatnonzero(np.diff(airborne) == -1)
    return [float(length) / FPS for length in ends - begins]


def base_path(take: Take) -> npt.NDArray[np.float64]:
    """Middle of the base, (f, 3) m."""
    return np.asarray(take.tet_points[:, take.rest[:, 2] < 1e-6].mean(axis=1))


def test_it_jumps_forward_and_stays_up(tmp_path: Path) -> None:
    take, measures = run("jump-i", tmp_path)
    assert max(flights(take)) >= 0.2
    path = base_path(take)
    assert path[-1, 0] - path[0, 0] >= 0.25
    assert abs(path[-1, 1] - path[0, 1]) < 0.05
    # two seconds after landing
    assert measures.tilt[-1] < 5.0
    assert measures.centre_of_mass[-1, 2] > 0.9 * measures.centre_of_mass[0, 2]


@pytest.mark.long
@pytest.mark.parametrize("options", [("friction=0.64",), ("friction=0.96",)])
def test_it_jumps_and_lands_on_other_floors(options: tuple[str, ...], tmp_path: Path) -> None:
    """How far it gets there (0.18 to 0.3 m) hangs on the step; that it stays up does not."""
    settings = [part for option in options for part in ("--set", option)]
    take, measures = run("jump-i", tmp_path, *settings)
    assert max(flights(take)) >= 0.2
    assert base_path(take)[-1, 0] > 0.1
    assert measures.tilt[-1] < 10.0


def test_it_jumps_in_place_three_times(tmp_path: Path) -> None:
    take, measures = run("jump-i-in-place", tmp_path)
    lengths = [length for length in flights(take) if length >= 0.15]
    assert len(lengths) == 3
    path = base_path(take)
    assert np.linalg.norm((path - path[0])[:, :2], axis=1).max() < 0.05
    assert measures.tilt[-1] < 5.0


def test_without_muscles_it_stays_on_the_floor(tmp_path: Path) -> None:
    take, _ = run("jump-i", tmp_path, "--controller", "none", "--seconds", "2")
    assert flights(take) == []
