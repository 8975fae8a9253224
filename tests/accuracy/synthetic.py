"""Runs that were never run: motions with errors of known order, for what judges them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.accuracy.analysis.design import first_points
from warp_softbody.accuracy.cases.case import ChartCase
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.outcome import RunOutcome

CASE = replace(CASES["cantilever"], meshes=((None, 0), (None, 1)))
EXACT = np.linspace(0.0, 0.3, 3 * 4 * 3).reshape(3, 4, 3)
FALL = 0.4


def outcome(settings: Settings) -> RunOutcome:
    """All nodes are off by dt / 4 along x and by h^2 / 100 along y, h = 1 / 2^level.

    The cost is that of as many steps as are made with as many tets, and some for the rest.
    """
    time, space = 0.25 * settings.time_step, 0.01 * 0.25**settings.level
    if settings.elements == "smoothed":
        space *= 0.1
    path = EXACT + np.array([time, space, 0.0])
    work = 1.0 + (settings.elements == "smoothed") + (settings.precision == "float64")
    return RunOutcome(
        status="complete",
        cost=work * 8.0**settings.level / settings.time_step,
        setup=0.1,
        memory=1.0,
        tets=810 * 8**settings.level,
        nodes=256,
        iterations=5.0,
        passes=1.0,
        qps=0.0,
        unconverged=0.0,
        functionals={"tip_fall": FALL - time - space},
        path=path.astype(np.float32),
    )


def outcomes(case: ChartCase = CASE) -> dict[Settings, RunOutcome]:
    """Of all points that do not depend on a measurement."""
    return {settings: outcome(settings) for settings in first_points(case)}
