"""exercise-h, measured from its stage, and the path that it follows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from warp_softbody.cli import main
from warp_softbody.controllers import Sway
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.reader import Take

AMPLITUDE, PERIOD, PERIODS, START = 0.09, 2.0, 4.0, 0.5
LEGS = (-1.0, 1.0)


def run(folder: Path, *options: str, volume: float = 0.05) -> tuple[Take, Measures]:
    """A run's stage, which has to be finite, valid, without inverted or sunken tets.

    Its volume may change by a share of 0.05, or by the 0.15 of the paper where it is pushed too.
    """
    stage = folder / "h.usdc"
    assert main(["run", "exercise-h", "--out", str(stage), "--fps", "60", "--quiet", *options]) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert np.abs(measures.volume_change).max() < volume
    assert measures.penetration.max() < 0.002
    return take, measures


def leg_ends(take: Take, side: float) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Masks of the nodes of a leg's foot and of its upper end."""
    leg = side * take.rest[:, 0] > 0.1
    return leg & (take.rest[:, 2] < 1e-6), leg & (take.rest[:, 2] > 1.0 - 1e-6)


def tracking_error(measures: Measures) -> float:
    """Largest distance from the sine along x after the first period, over the amplitude."""
    time = measures.times - START
    wanted = AMPLITUDE * np.sin(2.0 * np.pi * time / PERIOD)
    moved = measures.centre_of_mass[:, 0] - measures.centre_of_mass[0, 0]
    steady = (time >= PERIOD) & (time <= PERIOD * PERIODS)
    return float(np.abs(moved - wanted)[steady].max() / AMPLITUDE)


def test_its_centre_of_mass_follows_the_sine(tmp_path: Path) -> None:
    take, measures = run(tmp_path)
    # at least 8 % of the body's height, followed to a tenth
    height = np.ptp(take.rest[:, 2])
    assert AMPLITUDE >= 0.08 * height
    assert tracking_error(measures) < 0.1
    assert np.abs(measures.centre_of_mass[:, 1]).max() < 0.1 * AMPLITUDE
    # back where it began
    assert np.linalg.norm(measures.centre_of_mass[-1] - measures.centre_of_mass[0]) < 0.02


def test_its_legs_squash_and_its_feet_stay(tmp_path: Path) -> None:
    take, _ = run(tmp_path)
    for side in LEGS:
        foot, top = leg_ends(take, side)
        way = take.tet_points[:, top].mean(axis=1) - take.tet_points[:, foot].mean(axis=1)
        assert np.ptp(np.linalg.norm(way, axis=1)) > 0.05
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
    _, measures = run(tmp_path, *options, volume=0.15 if "push=0.2" in options else 0.05)
    assert tracking_error(measures) < 0.1


def test_without_muscles_it_stands_still(tmp_path: Path) -> None:
    _, measures = run(tmp_path, "--controller", "none", "--seconds", "3")
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
    with pytest.raises(InputError, match="sway period must be finite and above 0"):
        Sway(period=0.0)
