"""Rows of the controlled scenes.

Runs are as short as what is measured allows. The reference is one run on a refined mesh with half
the shipped time step; what it is not sure of is what mesh and time step change beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warp_softbody.accuracy.cases.case import FINER, OWN, TIME_STEPS, ChartCase

CONTROLLED: Mapping[str, tuple[Any, ...]] = {
    "level": (1,),
    "elements": ("linear",),
    "tangent": ("warped",),
    "precision": ("float64",),
    "tolerance": (1e-2, 1e-3),
    "newton_iterations": (2,),
    "cone": ("4", "8"),
    "method": ("static",),
    "qps": (1, 4, 64),
    "plan_cone": (4,),
    "preconditioner": ("two-level",),
    "threads": (2,),
}
"""Other values than shipped."""

LETTER: Mapping[str, Any] = {
    "controlled": True,
    "time_step": TIME_STEPS[1],
    "meshes": (OWN,),
    "time_steps": TIME_STEPS[:3],
    "knobs": CONTROLLED,
    "finest": (FINER, TIME_STEPS[2]),
    "beside": (OWN, TIME_STEPS[3]),
    "products": 6,
    "reach": 4.0,
    "quick": {
        "knobs": {"tolerance": (1e-2,), "qps": (1,), "plan_cone": (4,)},
        "finest": (OWN, TIME_STEPS[2]),
        "products": 2,
    },
}
ROLLING = {**LETTER, "knobs": {**CONTROLLED, "patches": (4, 8)}}
RETURNING = {
    **ROLLING,
    "finest": (FINER, TIME_STEPS[1]),
    "beside": (OWN, TIME_STEPS[2]),
    "quick": {**LETTER["quick"], "finest": (OWN, TIME_STEPS[1])},
}
"""Takes twice as long as the others."""
SLIDES = ("gone", "largest_tilt")
LEANING = {
    **LETTER,
    "tangent": "warped",
    "knobs": {name: values for name, values in CONTROLLED.items() if name != "tangent"},
}
"""Of a body whose volume is linear."""

LETTERS = (
    ChartCase(scene="exercise-h", seconds=3.5, functionals=("sway_error", "swing"), **LETTER),
    ChartCase(
        scene="balance-i",
        seconds=3.0,
        functionals=("largest_tilt", "upright_again", "last_tilt"),
        **LETTER,
    ),
    ChartCase(scene="slide-f", seconds=3.5, functionals=SLIDES, **LEANING),
    ChartCase(scene="slide-f-left", seconds=3.5, functionals=SLIDES, **LEANING),
    ChartCase(scene="slide-f-delayed", seconds=3.5, functionals=SLIDES, **LEANING),
    ChartCase(
        scene="jump-i",
        seconds=2.6,
        functionals=("apex", "way_ahead", "last_tilt"),
        **LETTER,
    ),
    ChartCase(
        scene="jump-i-in-place",
        given={"jumps": 1},
        seconds=2.2,
        functionals=("apex", "way_ahead", "last_tilt"),
        **LETTER,
    ),
    ChartCase(
        scene="jump-t",
        seconds=2.2,
        functionals=("heading", "apex", "last_tilt"),
        **LETTER,
    ),
    ChartCase(scene="roll-o", seconds=10.0, functionals=("rolled", "way_ahead"), **ROLLING),
    ChartCase(
        scene="roll-o-return",
        seconds=11.0,
        functionals=("rolled_furthest", "rolled_back"),
        **RETURNING,
    ),
    ChartCase(scene="crawl-i", seconds=2.9, functionals=("gone", "slipped"), **LETTER),
    ChartCase(
        scene="crawl-i-inchworm",
        seconds=2.9,
        functionals=("gone", "slipped", "arch"),
        **LETTER,
    ),
    ChartCase(
        scene="walk-x",
        seconds=3.6,
        functionals=("gone", "foot_lift", "largest_tilt"),
        **LETTER,
    ),
    ChartCase(
        scene="walk-x-fast",
        seconds=3.0,
        functionals=("gone", "foot_lift", "largest_tilt"),
        **LETTER,
    ),
)
