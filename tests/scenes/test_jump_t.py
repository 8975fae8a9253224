"""jump-t, measured from its stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.measures import flights
from tests.scenes.runs import missed, run


@pytest.mark.parametrize("friction", [0.8, pytest.param(0.64, marks=pytest.mark.long)])
def test_it_turns_in_the_air_and_lands_upright(friction: float, tmp_path: Path) -> None:
    motion = run("jump-t", tmp_path, "--set", f"friction={friction}")
    assert missed("jump-t", motion) == []
    assert sum(flights(motion.take)) >= 0.2
    # at rest two seconds later: a tenth of the 1.5 m/s with which it lands
    assert np.linalg.norm(motion.take.velocities[-1], axis=1).max() < 0.15
