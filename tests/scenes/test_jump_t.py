"""jump-t, measured from its stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warp_softbody.cli import main
from warp_softbody.stage_exports import measure, read_take, validate


@pytest.mark.parametrize("friction", [0.8, pytest.param(0.64, marks=pytest.mark.long)])
def test_it_turns_in_the_air_and_lands_upright(friction: float, tmp_path: Path) -> None:
    stage = tmp_path / "t.usdc"
    options = ["--fps", "60", "--quiet", "--set", f"friction={friction}"]
    assert main(["run", "jump-t", "--out", str(stage), *options]) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert measures.penetration.max() < 0.002
    rest = take.rest - take.rest.mean(axis=0)
    angles = []
    for points in take.tet_points:
        moments = rest.T @ (points - points.mean(axis=0))
        angles.append(np.arctan2(moments[0, 1] - moments[1, 0], moments[0, 0] + moments[1, 1]))
    yaw = np.degrees(np.unwrap(angles))
    airborne = np.flatnonzero(take.tet_points[:, :, 2].min(axis=1) > 1e-3)
    assert len(airborne) >= 0.2 * 60
    assert abs(yaw[airborne[-1]] - yaw[airborne[0]]) >= 45.0
    assert measures.tilt[-1] < 5.0
    assert measures.centre_of_mass[-1, 2] > 0.9 * measures.centre_of_mass[0, 2]
