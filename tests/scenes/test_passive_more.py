"""cantilever, twisted-bar and bounce-ball, measured from the stages of their runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.verification.accuracy import quarter_masses
from tests.verification.reference import elastic_energy
from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.cli import main
from warp_softbody.scenes import bounce_ball, twisted_bar
from warp_softbody.stage_exports import measure, read_take, validate
from warp_softbody.stage_exports.measures import Measures
from warp_softbody.stage_exports.usd.reader import Take

GRAVITY = 9.81
SETTLING = ("--time-step", "0.5", "--fps", "2", "--precision", "float64")
"""Equilibrium does not depend on the time step, and steps of half a second come to it soon."""


def run(folder: Path, scene: str, *options: str) -> tuple[Take, Measures]:
    """A run's stage, which has to be valid, finite and without inverted tets."""
    stage = folder / "take.usdc"
    assert main(["run", scene, "--out", str(stage), "--quiet", *options]) == 0
    assert validate(stage) == []
    take = read_take(stage)
    measures = measure(take)
    assert measures.finite.all()
    assert measures.smallest_volume_ratio.min() > 0.0
    return take, measures


def falls(take: Take) -> FloatArray:
    """Of the cantilever's tip face, (f,) m."""
    tip = take.rest[:, 0] > 1.0 - 1e-9
    return np.asarray((take.rest - take.tet_points)[:, tip, 2].mean(axis=1))


def turns(take: Take) -> FloatArray:
    """Of the bar's end face about x, (f,) rad."""
    end = take.rest[:, 0] > twisted_bar.LENGTH - 1e-9
    y, z = take.rest[end, 1], take.rest[end, 2]
    now_y, now_z = take.tet_points[:, end, 1], take.tet_points[:, end, 2]
    return np.asarray(
        np.arctan2((y * now_z - z * now_y).sum(axis=1), (y * now_y + z * now_z).sum(axis=1))
    )


def test_cantilever_sags_as_in_vegafem(tmp_path: Path) -> None:
    """VegaFEM's static solution of the same corotational tets is 0.21750 m, to five digits."""
    take, _ = run(tmp_path, "cantilever", *SETTLING, "--seconds", "20")
    sag = falls(take)
    assert abs(sag[-1] - sag[-2]) < 1e-7
    assert sag[-1] == pytest.approx(0.21750, abs=5e-6)


def test_cantilever_keeps_its_energy_but_for_what_implicit_steps_take(tmp_path: Path) -> None:
    """A mode of frequency w loses w^2 dt of its energy a second, and none is ever gained.

    The first mode of a uniform beam has w^2 = 3.516^2 g / (8 sag); its share of the swing's energy,
    which is the largest kinetic energy, is all but some percent, which may be lost wholly.
    """
    step = 1.0 / 960.0
    take, _ = run(
        tmp_path,
        "cantilever",
        "--time-step",
        str(step),
        "--seconds",
        "1.2",
        "--precision",
        "float64",
    )
    plan = scenes.make("cantilever")
    mesh, material = plan.scene.character.mesh, plan.scene.character.material
    masses = quarter_masses(mesh, material)
    kinetic = 0.5 * np.einsum("n,fni,fni->f", masses, take.velocities, take.velocities)
    weight = GRAVITY * take.tet_points[:, :, 2] @ masses
    elastic = [elastic_energy(mesh, material, points) for points in take.tet_points]
    lost = -np.diff(kinetic + weight + np.array(elastic)) / kinetic.max()
    # stages hold single precision: the weight's energy is 4 J of some 1e-7, the swing's 20 J
    assert lost.min() > -1e-5
    rate = 3.516**2 * GRAVITY / (8.0 * 0.2175) * step
    assert 0.5 * rate * 1.2 < lost.sum() < rate * 1.2 + 0.05


def test_bar_twists_as_saint_venant_says(tmp_path: Path) -> None:
    """By m L^2 / (2 G J) for a torque of m a length, J = 0.1406 a^4 of a square.

    The clamp keeps its section from warping: Vlasov's theory takes off 2 / (k L) of it, k^2 = G J /
    (E C) with C = 1.34e-4 a^6, which is 2.1 % here, an upper bound for a solid section.
    """
    settings = ("--set", "torque=0.2", "--set", "hold=100", "--set", "cells=6")
    take, _ = run(
        tmp_path, "twisted-bar", *SETTLING, *settings, "--elements", "smoothed", "--seconds", "8"
    )
    material, a, length = twisted_bar.MATERIAL, twisted_bar.SIDE, twisted_bar.LENGTH
    rigidity = material.lame_mu * 0.1406 * a**4
    k = np.sqrt(rigidity / (material.young_modulus * 1.34e-4 * a**6))
    angle = turns(take)
    assert abs(angle[-1] - angle[-2]) < 1e-4 * angle[-1]
    exact = 0.2 * length / (2.0 * rigidity)
    assert (1.0 - 2.0 / (k * length)) * exact < angle[-1] < exact


def test_bar_is_let_go_and_swings_about_its_rest(tmp_path: Path) -> None:
    take, measures = run(tmp_path, "twisted-bar")
    angle = turns(take)
    # a load that comes at once swings it to its largest turn in half a period, 2 L / c of torsion
    # waves; a mesh that locks is stiffer, and no softer
    wave = np.sqrt(0.1406 * 6.0 * twisted_bar.MATERIAL.lame_mu / twisted_bar.MATERIAL.density)
    half_period = 2.0 * twisted_bar.LENGTH / wave
    assert 0.5 * half_period < take.times[int(angle.argmax())] < half_period + 1.0 / 30.0
    assert np.degrees(angle.max()) > 30.0
    assert angle.min() < -0.3 * angle.max()
    # wrung, not bent: its axis stays where it is
    assert np.abs(measures.centre_of_mass[:, 1:]).max() < 0.02 * twisted_bar.SIDE


def test_ball_falls_freely_bounces_and_flies_freely(tmp_path: Path) -> None:
    """Between contacts the centre's velocity changes by g alone, to single precision."""
    step = 1.0 / 960.0
    take, measures = run(tmp_path, "bounce-ball", "--time-step", str(step), "--seconds", "0.7")
    heights = measures.centre_of_mass[:, 2]
    touches = np.array([len(contacts.points) > 0 for contacts in take.contacts])
    landing = float(np.sqrt(2.0 * 0.3 / GRAVITY))
    assert take.times[touches].min() == pytest.approx(landing, abs=1.0 / 30.0)
    falling = take.times < landing - 1.0 / 30.0
    # implicit Euler steps of dt
    way = 0.5 * GRAVITY * take.times * (take.times + step)
    np.testing.assert_allclose(heights[falling], (heights[0] - way)[falling], atol=2e-6)
    flying = np.flatnonzero(~touches & (take.times > landing))
    flying = flying[np.isin(flying + 1, flying)][1:]
    assert len(flying) >= 3
    # the centre from three frames on, at rest heights of 0.5 m of seven digits
    bend = heights[flying[1:] - 1] - 2.0 * heights[flying[1:]] + heights[flying[1:] + 1]
    np.testing.assert_allclose(bend, -GRAVITY / 30.0**2, atol=2e-6)
    lowest = int(heights[: len(heights) // 2].argmin())
    assert bounce_ball.RADIUS < heights[lowest:].max() < heights[0]
    assert measures.penetration.max() < 1e-4


def test_ball_comes_to_rest_and_its_weight_is_borne(tmp_path: Path) -> None:
    take, measures = run(tmp_path, "bounce-ball", "--seconds", "4")
    weight = bounce_ball.BALL.density * take_volume(take) * GRAVITY
    force = take.contacts[-1].forces.sum(axis=0)
    # what still moves, at 5 mm/s and less than 1 Hz, is 0.3 % of gravity
    assert np.linalg.norm(take.velocities[-1], axis=1).max() < 5e-3
    np.testing.assert_allclose(force, (0.0, 0.0, weight), atol=3e-3 * weight)
    assert measures.penetration[-1] < 1e-4


def take_volume(take: Take) -> float:
    a, b, c, d = (take.rest[take.tets[:, corner]] for corner in range(4))
    return float(np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)).sum() / 6.0)
