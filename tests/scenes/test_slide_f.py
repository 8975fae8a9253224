"""slide-f and its variants, measured from their stages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from warp_softbody import scenes
from warp_softbody.cli import main
from warp_softbody.scene import STANDARD_GRAVITY
from warp_softbody.stage_exports import measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.reader import Take

FRICTION, PULL = 0.1, 0.25  # of the scene; pull in body weights
STARTS, STRONGEST, ENDS = 0.5, 3.0, 3.5  # s, of the pull
SIDES = {"slide-f": 1.0, "slide-f-left": -1.0, "slide-f-delayed": 1.0}


def run(scene: str, folder: Path, *options: str) -> tuple[Take, Measures]:
    """A run's stage, which has to be finite, valid, without inverted or sunken tets."""
    stage = folder / "f.usdc"
    assert main(["run", scene, "--out", str(stage), "--fps", "60", "--quiet", *options]) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    assert np.abs(measures.volume_change).max() < 0.05
    assert measures.penetration.max() < 0.002
    return take, measures


def base_path(take: Take) -> npt.NDArray[np.float64]:
    """Middle of the base, (f, 3) m."""
    return np.asarray(take.tet_points[:, take.rest[:, 2] < 1e-6].mean(axis=1))


def leaning(take: Take) -> npt.NDArray[np.float64]:
    """Degrees by which head over base has turned from rest towards +x."""
    head, base = take.rest[:, 2] > 0.88 - 1e-6, take.rest[:, 2] < 1e-6
    way = [points[head].mean(axis=0) - points[base].mean(axis=0) for points in take.tet_points]
    rest = take.rest[head].mean(axis=0) - take.rest[base].mean(axis=0)
    x, _, z = np.array(way).T
    return np.asarray(np.degrees(np.arctan2(x, z) - np.arctan2(rest[0], rest[2])))


def assert_it_slides_upright(take: Take, measures: Measures, side: float) -> None:
    height = measures.centre_of_mass[:, 2]
    assert height.min() > 0.75 * height[0]
    assert measures.tilt.max() < 30.0
    moved = side * (base_path(take) - base_path(take)[0])[:, 0]
    assert moved[-1] > np.ptp(take.rest[:, 2])
    # it ends at rest
    assert np.ptp(moved[measures.times > measures.times[-1] - 0.5]) < 0.1


@pytest.mark.parametrize("scene", ["slide-f", "slide-f-left"])
def test_it_leans_against_the_pull_and_slides(scene: str, tmp_path: Path) -> None:
    take, measures = run(scene, tmp_path)
    assert_it_slides_upright(take, measures, SIDES[scene])
    pulled = (measures.times > STRONGEST - 0.5) & (measures.times < ENDS)
    # 2 degrees are 3 cm at the head; the limp body leans by tens of degrees the other way
    assert (SIDES[scene] * leaning(take)[pulled]).mean() < -2.0


def test_friction_cannot_hold_it_back_further(tmp_path: Path) -> None:
    """Friction is at most mu times the normal force, whose impulse is m g T plus a change of m v_z.

    So from when the pull exceeds mu m g until it is strongest, m v_x grows by the pull's impulse
    less that bound at least. Without the bound, by the pull's impulse at most.
    """
    take, measures = run("slide-f", tmp_path, "--seconds", "3")
    begins = STARTS + FRICTION / PULL * (STRONGEST - STARTS)
    path, times = measures.centre_of_mass, measures.times
    speed = np.gradient(path, times, axis=0)
    first, last = np.searchsorted(times, [begins, STRONGEST - 1.5 / take.fps])
    gained = speed[last] - speed[first]
    length = times[last] - times[first]
    pulled = np.interp(times, [STARTS, STRONGEST], [0.0, PULL])[first : last + 1]
    pull = STANDARD_GRAVITY * np.trapezoid(pulled, times[first : last + 1])
    bound = FRICTION * (STANDARD_GRAVITY * length + gained[2])
    # A central difference is the mean over two frames, so a frame of the forces may be missed.
    missed = (PULL + FRICTION) * STANDARD_GRAVITY / take.fps
    assert gained[0] > pull - bound - missed
    assert gained[0] < pull + missed


def test_it_recovers_when_it_starts_late(tmp_path: Path) -> None:
    take, measures = run("slide-f-delayed", tmp_path)
    limp = measures.times < STARTS + 0.3
    assert (take.activations[limp] == 1.0).all()
    assert (take.activations[~limp].min(axis=0) < 1.0).any()
    assert_it_slides_upright(take, measures, SIDES["slide-f-delayed"])


@pytest.mark.long
@pytest.mark.parametrize(
    "options",
    [
        ("--set", "friction=0.08"),
        ("--set", "friction=0.12"),
        ("--time-step", "0.00834"),
    ],
)
@pytest.mark.parametrize("scene", list(SIDES))
def test_it_slides_upright_elsewhere(scene: str, options: tuple[str, ...], tmp_path: Path) -> None:
    take, measures = run(scene, tmp_path, *options)
    height = measures.centre_of_mass[:, 2]
    assert height.min() > 0.5 * height[0]
    assert measures.tilt[-1] < 30.0
    assert abs(base_path(take)[-1, 0]) > np.ptp(take.rest[:, 2])


@pytest.mark.parametrize("scene", ["slide-f", "slide-f-left"])
def test_without_muscles_it_topples(scene: str, tmp_path: Path) -> None:
    _, measures = run(scene, tmp_path, "--controller", "none", "--seconds", "4")
    assert measures.centre_of_mass[-1, 2] < 0.6 * measures.centre_of_mass[0, 2]
    assert measures.tilt[-1] > 60.0


def test_the_pull_grows_evenly() -> None:
    """Its impulse is that of the ramp up and the ramp down; pieces at their middle keep it."""
    plan = scenes.make("slide-f-left", {"pull": 0.2})
    character = plan.scene.character
    weight = character.material.density * character.mesh.volume * STANDARD_GRAVITY
    impulse = sum(push.force[0] * push.duration for push in plan.scene.pushes)
    np.testing.assert_allclose(impulse, -0.5 * 0.2 * weight * (ENDS - STARTS))
    assert {push.region for push in plan.scene.pushes} == {"head"}
    assert scenes.make("slide-f", {"pull": 0.0}).scene.pushes == ()
