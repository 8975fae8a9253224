"""A letter of any size, under any gravity, moves like the one of a metre on Earth in scaled time.

Material, muscles, damping and pushes are scaled by similarity (`similar_scene`); the controllers
are the shipped ones, whose gains are in units of the body. In double precision and with a patient
search of contact modes: what is not scaled is to be found, not how rounding grows, nor which of two
minima that are within 1.5 % of each other a short search ends in.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from warp_softbody import ControlOptions, SimulationOptions, scenes
from warp_softbody.accuracy.cases.body_motion import turned
from warp_softbody.arrays import FloatArray
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.similar_scene import Similarity, similar_scene

MOON = 1.62 / 9.81

PATIENT = ControlOptions(kick_patience=40, kicks=80, kick_pause=0, max_qps=400)


class Path(NamedTuple):
    """Nodes (f, n, 3) over the length, their shares of the mass (n,), nodes at rest (n, 3)."""

    points: FloatArray
    shares: FloatArray
    rest: FloatArray

    @property
    def way(self) -> FloatArray:
        """Of the centre of mass, (f, 3), over the length."""
        middles = self.shares @ self.points
        return np.asarray(middles - middles[0])


@cache
def path(scene: str, seconds: float, by: Similarity = Similarity()) -> Path:  # noqa: B008
    """A run of a scene for as long as the shipped one takes to the given time, s."""
    plan = scenes.make(scene)
    options = SimulationOptions(time_step=plan.time_step * by.time, precision="float64")
    simulation = Simulation(
        similar_scene(plan.scene, by),
        plan.controller,
        options=options,
        control_options=PATIENT,
        fps=60.0 / by.time,
    )
    points = [frame.positions / by.length for frame in simulation.run(seconds * by.time)]
    masses = simulation.model.masses
    return Path(np.array(points), masses / masses.sum(), plan.scene.character.mesh.points)


def ahead(path: Path) -> float:
    """Way of the centre of mass along x, over the length."""
    return float(path.way[-1, 0])


def lean(path: Path) -> float:
    """Degrees about y at the end."""
    return float(turned(path.rest, path.points, 1, path.shares)[-1])


MOTIONS: dict[str, tuple[float, Callable[[Path], float], float]] = {
    "balance-i": (0.9, lean, 1.0),
    "jump-i": (1.45, ahead, 0.04),
    "roll-o": (1.2, lean, 10.0),
    "slide-f": (2.1, ahead, 0.05),
    "walk-x": (1.5, ahead, 0.02),
}
"""Time, s, after which a motion shows; its number, and the least that it is then."""


@pytest.mark.parametrize("scene", MOTIONS)
@pytest.mark.parametrize(
    "by",
    [Similarity(length=0.1), Similarity(length=10.0), Similarity(gravity=MOON)],
    ids=["a tenth", "ten times", "on the Moon"],
)
def test_a_letter_of_another_size_moves_alike(scene: str, by: Similarity) -> None:
    seconds, number, least = MOTIONS[scene]
    expected = number(path(scene, seconds))
    assert abs(expected) > least
    assert number(path(scene, seconds, by)) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("scene", ["crawl-i", "crawl-i-inchworm", "exercise-h"])
def test_factors_that_round_nothing_change_nothing(scene: str) -> None:
    """Length, time, speed and stress by powers of two: a number that is not scaled would show."""
    by = Similarity(length=1.0, gravity=0.25)
    expected, found = path(scene, 0.8), path(scene, 0.8, by)
    assert np.abs(expected.way).max() > 1e-3
    np.testing.assert_allclose(found.points, expected.points, rtol=0.0, atol=1e-6)
