"""A row of the table of charts, and the meshes and time steps that rows are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.engine.options import NamedElements, NamedTangent

Mesh = tuple["int | None", int]
"""Cells and level, as in `Settings`."""

COARSEST: Mesh = (None, -2)
COARSER: Mesh = (None, -1)
OWN: Mesh = (None, 0)
FINER: Mesh = (None, 1)
FINEST: Mesh = (None, 2)
TIME_STEPS = tuple(1.0 / (30 * 2**k) for k in range(8))
"""s: 1/30, 1/60, ... 1/3840; each fills a frame of 1/30 s a whole number of times."""


@dataclass(frozen=True, kw_only=True)
class ChartCase:
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
        tangent: shipped for a controlled body: conserving, where its volume is exact.
        quick: other values of these fields for `--quick`.
        products: most points that combine knobs, and most in a round of neighbours.
        reach: times the default's cost up to which knobs are combined.
        peers: other programs that can run it (`peer_runs.py`).
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
    elements: NamedElements = "smoothed"
    tangent: NamedTangent = "conserving"
    quick: Mapping[str, Any] = field(default_factory=dict)
    products: int = 24
    reach: float = 16.0
    peers: tuple[str, ...] = ()

    @property
    def default(self) -> Settings:
        """The point that `run` makes where nothing is said."""
        if self.controlled:
            return replace(self.usual, level=-shipped_coarse(self.scene))
        return self.usual

    @property
    def usual(self) -> Settings:
        """The same on the usual mesh, that of level 0, also where a coarser one ships."""
        if self.controlled:
            return Settings(time_step=self.time_step, elements="smoothed", tangent=self.tangent)
        return Settings(time_step=self.time_step)

    def has(self, settings: Settings) -> bool:
        """Whether the engine has this combination for the bodies of the scene.

        Smoothed elements have a conserving tangent where volumes are exact.
        """
        warped = settings.tangent in ("warped", self.default.tangent)
        return settings.possible and (settings.elements == "linear" or warped)

    def quickly(self) -> ChartCase:
        """The same, short and coarse."""
        return replace(self, **{"products": 6, **self.quick})


def shipped_coarse(scene: str) -> int:
    """How much coarser a mesh than the usual one a scene ships with; 0 where it has no such."""
    from warp_softbody import scenes

    defaults = {setting.name: setting.default for setting in scenes.recipe(scene).settings}
    return int(defaults.get("coarse", 0.0))
