"""A point of a chart that is to be run, and a key under which its outcome is kept."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property, lru_cache
from typing import Any

from warp_softbody import __version__
from warp_softbody.accuracy.cases.settings import Settings

FPS = 30.0
"""Frames per simulated second at which a run is recorded."""

UNTIMED_STEPS = 1
"""The first step captures its graphs."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A point to be run.

    Attributes:
        scene: its name.
        given: settings of the scene beside `Settings.cells`.
        seconds: simulated, s.
        functionals: names of those to be measured.
        settings: the knobs.
        solver: "ours", or the name of a peer.
    """

    scene: str
    given: Mapping[str, float] = field(default_factory=dict)
    seconds: float
    functionals: tuple[str, ...]
    settings: Settings
    solver: str = "ours"

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {**asdict(self), "given": dict(self.given), "functionals": list(self.functionals)}

    @cached_property
    def key(self) -> str:
        """The same for the same scene, settings and version of the program."""
        scene = fingerprint(self.scene, tuple(sorted(self.given.items())), self.settings.cells)
        values = {**self.to_dict(), "fingerprint": scene, "version": __version__}
        text = json.dumps(values, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


@lru_cache
def fingerprint(scene: str, given: tuple[tuple[str, float], ...], cells: int | None) -> str:
    """Of the bodies, of what acts on them and of the controller's numbers, before refinement."""
    plan = Settings(time_step=1.0, cells=cells).plan(scene, dict(given))
    found = hashlib.sha256(repr((plan.settings, plan.scene.pushes, plan.scene.gravity)).encode())
    if plan.controller is not None:
        numbers = [repr(value) for value in vars(plan.controller).values()]
        # objects without a text of their own are told by an address, which changes
        found.update("".join(text for text in numbers if " at 0x" not in text).encode())
    for body in plan.scene.characters:
        found.update(body.mesh.points.tobytes() + body.mesh.tets.tobytes())
        found.update(repr((body.material, body.directional_friction)).encode())
        for group in body.muscles:
            found.update(repr((group.name, group.strength, group.kernel_width)).encode())
        for fiber in body.fibers:
            found.update(repr((fiber.name, fiber.kind)).encode() + fiber.vertices.tobytes())
    return found.hexdigest()
