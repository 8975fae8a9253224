"""Units of a body: its length L and the time sqrt(L / g), in which gains mean the same at any size.

A body of another size, or under another gravity, whose stiffness, muscles and pushes are scaled
likewise moves alike in these units (McMahon and Bonner, On Size and Life, 1983). Gains are given in
them, each field with its dimension; controllers reckon in SI units.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from warp_softbody.inputs import checks
from warp_softbody.world.scene import STANDARD_GRAVITY, Scene
from warp_softbody.world.view import BodyView

Gains = TypeVar("Gains")

LEAST_GRAVITY = 1e-6
"""m/s^2, below which gravity is none."""

_DIMENSION = "dimension"


@dataclass(frozen=True, kw_only=True)
class BodyUnits:
    """The units of a body.

    Attributes:
        length: L, m: the largest side of the box around the character's rest shape, along x, y or
            z; of the shipped letters 1 m.
        time: sqrt(L / g), s; g is the size of the scene's gravity, or Earth's where it has none.
    """

    length: float
    time: float

    def __post_init__(self) -> None:
        """Refuse units that are not positive."""
        checks.settle(self, positive=("length", "time"))

    @classmethod
    def of(cls, view: BodyView) -> BodyUnits:
        """Those of the body that a controller sees."""
        return cls.of_scene(checks.instance("view of BodyUnits", view, BodyView).scene)

    @classmethod
    def of_scene(cls, scene: Scene) -> BodyUnits:
        """Those of a scene's character."""
        checks.instance("scene of BodyUnits", scene, Scene)
        # asked for many times a step; a scene does not change
        known = scene.__dict__.get("_body_units")
        if known is None:
            known = scene.__dict__["_body_units"] = cls._measured(scene)
        units: BodyUnits = known
        return units

    @classmethod
    def _measured(cls, scene: Scene) -> BodyUnits:
        low, high = scene.character.mesh.bounds
        length = float((high - low).max())
        gravity = float(np.linalg.norm(scene.gravity))
        if not gravity > LEAST_GRAVITY:
            gravity = STANDARD_GRAVITY
        return cls(length=length, time=float(np.sqrt(length / gravity)))

    @property
    def speed(self) -> float:
        """sqrt(g L), m/s."""
        return self.length / self.time


def dimension(*, length: float = 0.0, time: float = 0.0) -> Mapping[str, Any]:
    """Metadata of a field of gains that is given in L^length (L / g)^(time / 2)."""
    return {_DIMENSION: (length, time)}


def in_si(gains: Gains, units: BodyUnits) -> Gains:
    """Gains with every field that has a dimension in SI units, also in dataclasses among them.

    Fields are numbers or tuples of numbers; those without a dimension stay.
    """
    changes: dict[str, Any] = {}
    for entry in fields(gains):  # type: ignore[arg-type]
        value = getattr(gains, entry.name)
        if is_dataclass(value) and not isinstance(value, type):
            changes[entry.name] = in_si(value, units)
        elif _DIMENSION in entry.metadata:
            length, time = entry.metadata[_DIMENSION]
            unit = units.length**length * units.time**time
            scaled = [unit * number for number in value] if isinstance(value, tuple) else None
            changes[entry.name] = unit * value if scaled is None else tuple(scaled)
    return replace(gains, **changes)  # type: ignore[type-var]
