"""What is watched between frames, and what it keeps off the frontier."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.accuracy.synthetic import CASE, outcome
from warp_softbody import scenes
from warp_softbody.accuracy.analysis.chart import Point
from warp_softbody.accuracy.analysis.motion import MeasuredMotion, Ruler
from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.runs.soundness_monitor import SoundnessMonitor
from warp_softbody.run.simulation import Simulation


def test_volume_and_turning_accelerations() -> None:
    """A cube grown by a tenth along one axis; velocities that swing to and fro, or grow."""
    plan = scenes.make("drop-block")
    view = Simulation(plan.scene).view()
    for signs, share in (((1, -1, 1, -1), 1.0), ((1, 3, 6, 10), 0.0)):
        monitor = SoundnessMonitor(plan.scene)
        for sign in signs:
            velocities = np.zeros_like(view.positions)
            velocities[:, 0] = sign
            stretched = view.positions * np.array([1.1, 1.0, 1.0])
            monitor.see(replace(view, positions=stretched, velocities=velocities))
        seen = monitor.seen()
        assert seen.volume == pytest.approx(0.1)
        assert seen.reversals == share


def test_what_shakes_is_not_offered_however_right_its_outcome() -> None:
    calm = outcome(CASE.default)
    limit = FUNCTIONALS["reversals"].limit
    assert limit is not None
    values = {**calm.functionals, "volume": 0.01, "reversals": 0.9 * limit}
    point = Point(settings=CASE.default, outcome=replace(calm, functionals=values), error=0.0)
    assert point.eligible
    shaking = {**values, "reversals": 1.1 * limit}
    assert not replace(point, outcome=replace(calm, functionals=shaking)).eligible
    # and how much it shakes is no part of its error
    there, here = (
        MeasuredMotion(path=np.zeros((1, 1, 3)), functionals=each) for each in (values, shaking)
    )
    assert Ruler(size=1.0, by_functionals=True).distance(there, here) == 0.0
