"""exercise-h, measured from its stage, and the path that it follows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from benchmarks.motions.criteria import SWAY, sway_error
from tests.scenes.runs import Shipped, missed, run
from warp_softbody.controllers import Sway
from warp_softbody.errors import InputError
from warp_softbody.stage_exports.usd.reader import Take

LEGS = (-1.0, 1.0)


def foot_of(take: Take, side: float) -> npt.NDArray[np.bool_]:
    """Mask of the nodes of a leg's foot."""
    return np.asarray((side * take.rest[:, 0] > 0.1) & (take.rest[:, 2] < 1e-6))


def test_its_centre_of_mass_follows_the_sine(shipped: Shipped) -> None:
    motion = shipped("exercise-h")
    # at least 8 % of the body's height
    assert np.ptp(motion.take.rest[:, 2]) * 0.08 <= SWAY
    assert missed("exercise-h", motion) == []
    measures = motion.measures
    assert np.abs(measures.centre_of_mass[:, 1]).max() < 0.1 * SWAY
    # back where it began
    assert np.linalg.norm(measures.centre_of_mass[-1] - measures.centre_of_mass[0]) < 0.02


def test_its_feet_stay(shipped: Shipped) -> None:
    take = shipped("exercise-h").take
    for side in LEGS:
        foot = foot_of(take, side)
        # it rolls on its edges, but some of it always stands
        assert take.tet_points[:, foot, 2].min(axis=1).max() < 0.001
        moved = (take.tet_points[-1, foot] - take.tet_points[0, foot]).mean(axis=0)
        assert np.hypot(moved[0], moved[1]) < 0.05


@pytest.mark.long
@pytest.mark.parametrize(
    "options",
    [
        ("--set", "friction=0.64"),
        ("--set", "friction=0.96"),
        ("--set", "push=0.2"),
        ("--time-step", "0.00834"),
    ],
)
def test_it_follows_the_sine_elsewhere(options: tuple[str, ...], tmp_path: Path) -> None:
    motion = run("exercise-h", tmp_path, *options)
    assert sway_error(motion) < 0.1


def test_without_muscles_it_stands_still(tmp_path: Path) -> None:
    measures = run("exercise-h", tmp_path, "--controller", "none", "--seconds", "3").measures
    assert np.abs(measures.centre_of_mass[:, :2]).max() < 0.005


def test_the_path_is_its_own_derivative() -> None:
    """Central differences of place and velocity are the velocity and the acceleration."""
    amplitude, ease, rate, step = 0.1, 0.5, np.pi, 1e-4
    path = Sway(amplitude=amplitude, period=2.0, periods=2.0, ease=ease)
    # The largest derivatives of the smooth step are 60, 5.8 and 1.9, in units of its length.
    jerk = amplitude * (
        60.0 / ease**3 + 3.0 * 5.8 / ease**2 * rate + 3.0 * 1.9 / ease * rate**2 + rate**3
    )
    # The acceleration is continuous, its slope jumps: it differs by a step of jerk at most.
    bounds = np.array([jerk * step**2 / 6.0, jerk * step / 2.0]) + 1e-11
    for time in np.linspace(-0.5, 5.0, 111):
        ahead, now, behind = path.at(time + step), path.at(time), path.at(time - step)
        slopes = (ahead - behind)[:2] / (2.0 * step)
        assert (np.abs(slopes - now[1:]) <= bounds).all()


def test_a_path_without_length_is_refused() -> None:
    with pytest.raises(InputError, match=r"Sway.period must be a positive number"):
        Sway(period=0.0)
