"""Rows of the controlled scenes.

Runs are as short as what is measured allows. The reference is one run on a refined mesh, with the
shipped time step or half of it; what it is not sure of is what mesh and step change beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warp_softbody.accuracy.cases.case import (
    COARSER,
    COARSEST,
    FINER,
    FINEST,
    OWN,
    TIME_STEPS,
    ChartCase,
    Mesh,
)

CONTROLLED: Mapping[str, tuple[Any, ...]] = {"tolerance": (1e-2,), "method": ("static",)}
"""Other values than shipped. Finer meshes are the references'; linear elements, tangents, other
numbers of QPs, planned cones and patches, two Newton iterations, cones of the simulator, two levels
and threads cost no less wherever they were charted."""

SOUND = ("volume", "reversals")
"""What settings have to keep small, whatever they are to be right by."""

LETTER: Mapping[str, Any] = {
    "controlled": True,
    "time_step": TIME_STEPS[1],
    "meshes": (COARSEST, COARSER, OWN),
    "time_steps": TIME_STEPS[:3],
    "knobs": CONTROLLED,
    "finest": (FINER, TIME_STEPS[1]),
    "beside": (OWN, TIME_STEPS[2]),
    "products": 2,
    "reach": 4.0,
    "quick": {
        "meshes": (OWN,),
        "knobs": {"tolerance": (1e-2,), "qps": (1,), "plan_cone": (4,)},
        "finest": (OWN, TIME_STEPS[1]),
        "products": 2,
    },
}
HALVED: Mapping[str, Any] = {
    **LETTER,
    "finest": (FINER, TIME_STEPS[2]),
    "beside": (OWN, TIME_STEPS[3]),
    "quick": {**LETTER["quick"], "finest": (OWN, TIME_STEPS[2])},
}
"""Of motions that the step moves most: their reference has half of it."""
QUARTERED: Mapping[str, Any] = {
    **LETTER,
    "finest": (FINER, TIME_STEPS[3]),
    "beside": (OWN, TIME_STEPS[4]),
    "quick": {**LETTER["quick"], "finest": (OWN, TIME_STEPS[3])},
}
"""Of a motion that changes by more from half of the step to a quarter than from the whole to half:
there plans for whole steps of the horizon go over to their limit."""
COMPACT: tuple[Mesh, ...] = (COARSER, OWN)
"""Of a letter with one coarser mesh."""
ROLLING: Mapping[str, Any] = {**LETTER, "meshes": COMPACT}
WALKING: Mapping[str, Any] = {**HALVED, "meshes": COMPACT}
SLIDES = ("gone", "largest_tilt", *SOUND)
LEANING = {**HALVED, "tangent": "warped"}
"""Of a body whose volume is linear."""
CAUGHT: Mapping[str, Any] = {
    **LEANING,
    "finest": (FINEST, TIME_STEPS[1]),
    "beside": (FINER, TIME_STEPS[2]),
    "quick": {**LETTER["quick"], "beside": (OWN, TIME_STEPS[2])},
}
"""Limp at first: how far it falls before it is caught, and slips in being caught, is an eighth more
on the refined mesh, so that this has to be refined as well. It has 654 tets, which pays for that.
"""

LETTERS = (
    ChartCase(
        scene="exercise-h", seconds=3.5, functionals=("sway_error", "swing", *SOUND), **HALVED
    ),
    ChartCase(
        scene="balance-i",
        seconds=3.0,
        functionals=("largest_tilt", "upright_again", "last_tilt", *SOUND),
        **HALVED,
    ),
    ChartCase(scene="slide-f", seconds=7.0, functionals=SLIDES, **LEANING),
    ChartCase(scene="slide-f-left", seconds=7.0, functionals=SLIDES, **LEANING),
    ChartCase(scene="slide-f-delayed", seconds=7.0, functionals=SLIDES, **CAUGHT),
    ChartCase(
        scene="jump-i",
        seconds=2.6,
        functionals=("gone", "take_off_speed", "last_tilt", *SOUND),
        **LETTER,
    ),
    ChartCase(
        scene="jump-i-in-place",
        given={"jumps": 1},
        seconds=2.2,
        functionals=("take_off_speed", "way_ahead", "last_tilt", *SOUND),
        **LETTER,
    ),
    ChartCase(
        scene="jump-t",
        seconds=2.6,
        functionals=("turned_in_air", "take_off_speed", "last_tilt", *SOUND),
        **QUARTERED,
    ),
    ChartCase(scene="roll-o", seconds=10.0, functionals=("rolled", "gone", *SOUND), **ROLLING),
    ChartCase(
        scene="roll-o-return",
        seconds=14.0,
        functionals=("rolled_furthest", "rolled_back", *SOUND),
        **ROLLING,
    ),
    ChartCase(scene="crawl-i", seconds=2.9, functionals=("gone", "slipped", *SOUND), **LETTER),
    ChartCase(
        scene="crawl-i-inchworm",
        seconds=2.9,
        functionals=("gone", "slipped", "arch", *SOUND),
        **HALVED,
    ),
    ChartCase(
        scene="walk-x",
        seconds=7.5,
        functionals=("gone", "swing_height", "largest_tilt", *SOUND),
        **WALKING,
    ),
    ChartCase(
        scene="walk-x-fast",
        seconds=5.5,
        functionals=("gone", "swing_height", "largest_tilt", *SOUND),
        **WALKING,
    ),
)
