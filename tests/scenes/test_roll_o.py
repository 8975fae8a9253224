"""roll-o and roll-o-return, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from warp_softbody.cli import main
from warp_softbody.stage_exports import measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.reader import Take


def run(scene: str, folder: Path, *options: str) -> tuple[Take, Measures]:
    """A run's stage, which has to be finite, valid, without inverted or sunken tets."""
    stage = folder / "roll.usdc"
    assert main(["run", scene, "--out", str(stage), "--fps", "60", "--quiet", *options]) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert np.abs(measures.volume_change).max() < 0.15
    assert measures.penetration.max() < 0.002
    return take, measures


def turned(take: Take) -> npt.NDArray[np.float64]:
    """Degrees that the body has turned about y, from the rotation that fits its nodes best."""
    rest = take.rest - take.rest.mean(axis=0)
    angles = []
    for points in take.tet_points:
        moments = rest.T @ (points - points.mean(axis=0))
        across, along = moments[2, 0] - moments[0, 2], moments[0, 0] + moments[2, 2]
        angles.append(np.arctan2(across, along))
    return np.degrees(np.unwrap(angles))


def test_it_rolls_more_than_once_around(tmp_path: Path) -> None:
    take, measures = run("roll-o", tmp_path)
    angle = turned(take)
    assert angle[-1] > 360.0
    way = measures.centre_of_mass[:, 0]
    # no slipping on the spot: the way is that of the rim, to a fifth
    assert abs(way[-1] - np.radians(angle[-1]) * 0.5) < 0.2 * way[-1]
    assert np.abs(measures.centre_of_mass[:, 1]).max() < 0.1


def test_it_stops_and_rolls_back(tmp_path: Path) -> None:
    take, _ = run("roll-o-return", tmp_path)
    angle = turned(take)
    furthest = int(angle.argmax())
    assert angle[furthest] > 180.0
    assert angle[furthest:].min() < angle[furthest] - 180.0


def test_limp_it_stays_where_it_stands(tmp_path: Path) -> None:
    take, _ = run("roll-o", tmp_path, "--controller", "none", "--seconds", "3")
    assert np.abs(turned(take)).max() < 5.0
