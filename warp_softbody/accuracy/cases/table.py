"""What is charted of each scene: what counts as error, for how long, and its knobs' ranges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warp_softbody.accuracy.cases.case import FINER, FINEST, OWN, TIME_STEPS, ChartCase
from warp_softbody.accuracy.cases.letter_rows import LETTERS
from warp_softbody.errors import InputError

PASSIVE: Mapping[str, tuple[Any, ...]] = {
    "elements": ("smoothed",),
    "tangent": ("conserving", "exact"),
    "precision": ("float64",),
    "tolerance": (1e-2, 1e-3, 1e-4, 1e-5),
    "newton_iterations": (2,),
    "threads": (2,),
    "preconditioner": ("two-level",),
}
CONTACT = {**PASSIVE, "cone": ("4", "8")}
BEAM: Mapping[str, Any] = {
    "seconds": 1.0,
    "meshes": ((1, 0), (2, 0), OWN, FINER),
    "time_steps": TIME_STEPS[:5],
    "knobs": PASSIVE,
    "finest": (FINEST, TIME_STEPS[2]),
    "beside": (FINER, TIME_STEPS[5]),
    "quick": {
        "seconds": 0.5,
        "meshes": ((1, 0), (2, 0), OWN),
        "time_steps": TIME_STEPS[:4],
        "finest": (FINER, TIME_STEPS[3]),
        "beside": (OWN, TIME_STEPS[4]),
    },
}
SHORT: Mapping[str, Any] = {
    "time_steps": TIME_STEPS[:4],
    "finest": (FINER, TIME_STEPS[2]),
    "beside": (OWN, TIME_STEPS[4]),
}
CASES = {
    case.scene: case
    for case in (
        ChartCase(
            scene="cantilever",
            functionals=("tip_fall",),
            peers=("MuJoCo flex", "Pardiso"),
            **BEAM,
        ),
        ChartCase(scene="twisted-bar", functionals=("end_turn",), **BEAM),
        ChartCase(
            scene="bounce-ball",
            seconds=0.8,
            functionals=("rebound",),
            meshes=((0, 0), (1, 0), OWN, FINER),
            time_steps=TIME_STEPS[:7],
            knobs=CONTACT,
            finest=(FINER, TIME_STEPS[5]),
            beside=(OWN, TIME_STEPS[7]),
            quick={"seconds": 0.6, "meshes": ((0, 0), (1, 0), OWN), **SHORT},
        ),
        ChartCase(
            scene="drop-block",
            seconds=0.5,
            functionals=("way_ahead",),
            meshes=((2, 0), (4, 0), OWN, FINER),
            time_steps=TIME_STEPS[:5],
            knobs=CONTACT,
            finest=(FINER, TIME_STEPS[4]),
            beside=(OWN, TIME_STEPS[6]),
            peers=("MuJoCo flex",),
            quick={"seconds": 0.3, "meshes": ((2, 0), (4, 0), OWN), **SHORT},
        ),
        ChartCase(
            scene="slope",
            seconds=1.0,
            functionals=("way",),
            meshes=((1, 0), OWN, FINER),
            time_steps=TIME_STEPS[:5],
            knobs=CONTACT,
            finest=(FINEST, TIME_STEPS[2]),
            beside=(FINER, TIME_STEPS[5]),
            quick={"seconds": 0.5, "meshes": (OWN,), **SHORT},
        ),
        ChartCase(
            scene="stack",
            given={"count": 2},
            seconds=0.8,
            functionals=("top_height",),
            meshes=(OWN, FINER),
            time_steps=TIME_STEPS[:5],
            knobs=PASSIVE,
            finest=(FINER, TIME_STEPS[4]),
            beside=(OWN, TIME_STEPS[6]),
            quick={"seconds": 0.4, "meshes": (OWN,), **SHORT},
        ),
        *LETTERS,
    )
}
"""One row a scene."""


def case_of(scene: str) -> ChartCase:
    """The row of a scene; one sentence where it has none."""
    if scene not in CASES:
        from warp_softbody import scenes

        scenes.recipe(scene)
        raise InputError(f"scene {scene!r} has no chart; charted are: {', '.join(CASES)}")
    return CASES[scene]
