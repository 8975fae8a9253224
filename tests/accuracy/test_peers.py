"""Other programs on a chart: they move the same body, and are measured in the same way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import scenes
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs.flex import FlexOnFloor
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.running import run_job

pytest.importorskip("mujoco")
pytest.importorskip("pypardiso")

JOB = Job(
    scene="cantilever",
    seconds=0.2,
    functionals=("tip_fall",),
    settings=Settings(time_step=1.0 / 60.0, precision="float64", tolerance=1e-8),
)


def test_pardiso_makes_the_same_steps() -> None:
    """The same equations: 12 steps agree to the tolerance of the linear solves, 1e-8 of 0.2 m."""
    ours, peer = run_job(JOB), run_job(replace(JOB, solver="Pardiso"))
    assert (peer.status, peer.tets) == ("complete", ours.tets) and peer.cost > 0.0
    # paths are kept in single precision
    np.testing.assert_allclose(peer.path, ours.path, atol=2e-7)


def test_mujoco_falls_like_ours_but_for_its_law() -> None:
    """The laws differ by the strain, half the height times the curvature: 5 % at 0.2 m of fall."""
    ours, peer = run_job(JOB), run_job(replace(JOB, solver="MuJoCo flex"))
    assert peer.complete and peer.cost > 0.0
    assert peer.functionals["tip_fall"] == pytest.approx(ours.functionals["tip_fall"], rel=0.05)


def test_flex_falls_freely_and_lands_on_the_floor() -> None:
    scene = scenes.make("drop-block").scene
    step = 1.0 / 480.0
    body = FlexOnFloor(scene, step)
    rest = scene.character.mesh.points
    for _ in range(36):
        assert body.step().converged
    time = 36 * step
    moved = (body.positions() - rest).mean(axis=0)
    # semi-implicit steps, as ours
    np.testing.assert_allclose(moved, (time, 0.0, -0.5 * 9.81 * time * (time + step)), atol=1e-6)
    for _ in range(60):
        body.step()
    # lands after 0.1 s at 1 m/s; a constraint of two steps' time constant gives way for some steps
    assert -4.0 * step < body.positions()[:, 2].min() < 0.01
