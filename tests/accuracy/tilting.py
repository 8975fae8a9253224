"""A controlled body whose largest tilt is off by what it is computed with; nothing is run."""

from __future__ import annotations

import numpy as np

from warp_softbody.accuracy.analysis.chart import Chart, Point
from warp_softbody.accuracy.analysis.design import first_points
from warp_softbody.accuracy.analysis.motion import Ruler
from warp_softbody.accuracy.analysis.reference import reference_of
from warp_softbody.accuracy.cases.case import ChartCase
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.outcome import RunOutcome

RULER = Ruler(size=1.0, by_functionals=True)
CASE = CASES["balance-i"]
TILT = 20.0
STEP_DOES, MESH_DOES, KNOB_DOES = 0.3, 5.4, 0.9
"""Degrees: for each 1/240 s of the step, of the coarser mesh, and of a looser solve."""


def outcome(settings: Settings) -> RunOutcome:
    """A largest tilt that is off by the time step, the mesh and the tolerance; nothing else is."""
    off = STEP_DOES * 240.0 * settings.time_step
    off += MESH_DOES * 4.0**-settings.level * (settings.level <= 0)
    off += KNOB_DOES * (settings.tolerance == 1e-2)
    work = 8.0**settings.level * (0.7 if settings.tolerance == 1e-2 else 1.0)
    return RunOutcome(
        status="complete",
        cost=10.0 * work / settings.time_step,
        setup=0.1,
        memory=1.0,
        tets=1048 * 8**settings.level,
        nodes=300,
        iterations=5.0,
        passes=1.0,
        qps=2.0,
        unconverged=0.0,
        functionals={"largest_tilt": TILT + off, "upright_again": 2.0, "last_tilt": 0.0},
        path=np.zeros((2, 4, 3), dtype=np.float32),
    )


def outcomes(case: ChartCase = CASE) -> dict[Settings, RunOutcome]:
    return {settings: outcome(settings) for settings in first_points(case)}


def chart(case: ChartCase = CASE) -> Chart:
    """All first points, judged."""
    runs = outcomes(case)
    reference = reference_of(case, runs, RULER)
    points = [
        Point(settings=one, outcome=run, error=reference.error(run)) for one, run in runs.items()
    ]
    return Chart(case=case, reference=reference, points=tuple(points))
