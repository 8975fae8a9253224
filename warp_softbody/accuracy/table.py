"""What is charted of each scene: what counts as error, for how long, and its knobs' ranges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from warp_softbody.accuracy.settings import Settings
from warp_softbody.errors import InputError
from warp_softbody.options import Elements

Mesh = tuple["int | None", int]
"""Cells and level, as in `Settings`."""

OWN: Mesh = (None, 0)
TIME_STEPS = tuple(1.0 / (30 * 2**k) for k in range(8))
"""s: 1/30, 1/60, ... 1/3840; each fills a frame of 1/30 s a whole number of times."""

PASSIVE: Mapping[str, tuple[Any, ...]] = {
    "elements": ("smoothed",),
    "tangent": ("conserving", "exact"),
    "precision": ("float64",),
    "tolerance": (1e-2, 1e-3, 1e-4, 1e-5),
    "newton_iterations": (2,),
    "threads": (2,),
}
CONTACT = {**PASSIVE, "cone": ("4", "8")}
CONTROLLED = {
    "elements": ("smoothed",),
    "precision": ("float64",),
    "tolerance": (1e-2, 1e-3, 1e-4),
    "newton_iterations": (2,),
    "method": ("static",),
    "qps": (1, 4, 64),
}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A row of the table.

    Attributes:
        scene: its name.
        given: its settings beside `cells`.
        seconds: simulated.
        functionals: what is measured of the motion, the first one first.
        controlled: errors are those of the functionals, as a controller's trajectories part.
        time_step: the shipped one, s.
        meshes: of the grid, coarse to fine; those with cells where the scene has that setting.
        time_steps: of the grid, coarse to fine.
        knobs: other values than the default's.
        finest, beside: meshes of the reference and their smallest time steps (`reference.py`).
        elements: of the reference.
        quick: other values of these fields for `--quick`.
        products: most points that combine knobs, and most in a round of neighbours.
        reach: times the default's cost up to which knobs are combined.
        peers: other programs that can run it (`peers.py`).
    """

    scene: str
    given: Mapping[str, float] = field(default_factory=dict)
    seconds: float
    functionals: tuple[str, ...]
    controlled: bool = False
    time_step: float = 1.0 / 120.0
    meshes: tuple[Mesh, ...]
    time_steps: tuple[float, ...]
    knobs: Mapping[str, tuple[Any, ...]]
    finest: tuple[Mesh, float]
    beside: tuple[Mesh, float]
    elements: Elements = "smoothed"
    quick: Mapping[str, Any] = field(default_factory=dict)
    products: int = 24
    reach: float = 16.0
    peers: tuple[str, ...] = ()

    @property
    def default(self) -> Settings:
        """The point that `run` makes where nothing is said."""
        return Settings(time_step=self.time_step)

    def quickly(self) -> Case:
        """The same, short and coarse."""
        return replace(self, **{"products": 6, **self.quick})


FINER: Mesh = (None, 1)
FINEST: Mesh = (None, 2)
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
LETTER: Mapping[str, Any] = {
    "controlled": True,
    "time_step": TIME_STEPS[1],
    "meshes": (OWN, FINER),
    "time_steps": TIME_STEPS[:3],
    "knobs": CONTROLLED,
    "finest": (FINER, TIME_STEPS[3]),
    "beside": (OWN, TIME_STEPS[3]),
    "elements": "linear",
    "products": 8,
    "reach": 4.0,
    "quick": {
        "meshes": (OWN,),
        "time_steps": TIME_STEPS[:3],
        "finest": (OWN, TIME_STEPS[3]),
        "beside": (OWN, TIME_STEPS[3]),
    },
}

CASES = {
    case.scene: case
    for case in (
        Case(
            scene="cantilever",
            functionals=("tip_fall",),
            peers=("MuJoCo flex", "Pardiso"),
            **BEAM,
        ),
        Case(scene="twisted-bar", functionals=("end_turn",), **BEAM),
        Case(
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
        Case(
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
        Case(
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
        Case(
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
        Case(
            scene="balance-i",
            seconds=3.0,
            functionals=("largest_tilt", "upright_again", "last_tilt"),
            **LETTER,
        ),
        Case(
            scene="jump-i",
            seconds=3.0,
            functionals=("apex", "way_ahead", "last_tilt"),
            **LETTER,
        ),
        Case(scene="roll-o", seconds=3.0, functionals=("rolled", "way_ahead"), **LETTER),
    )
}
"""One row a scene."""


def case_of(scene: str) -> Case:
    """The row of a scene; one sentence where it has none."""
    if scene not in CASES:
        from warp_softbody import scenes

        scenes.recipe(scene)
        raise InputError(f"scene {scene!r} has no chart; charted are: {', '.join(CASES)}")
    return CASES[scene]
