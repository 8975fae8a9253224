"""Every ground answers the protocol `Ground`; the simplest is `Plane`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, cast

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.inputs import array_checks, checks
from warp_softbody.world.friction_map import FrictionMap, checked_map

Vector = tuple[float, float, float]


class Ground(Protocol):
    """A fixed ground with Coulomb friction; how the engine finds it is in `ground_detection`."""

    @property
    def friction(self) -> float:
        """Coulomb coefficient mu, >= 0."""
        ...

    @property
    def normal(self) -> Vector:
        """The unit direction that counts as up on it as a whole."""
        ...

    def measure(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distances (k,) m of points (k, 3) and the ground's outward normals there (k, 3).

        Over a plane and a height field the distance is that to the plane of the triangle below.
        """
        ...


def checked_ground(label: str, ground: object) -> Ground:
    """Refuse what does not answer as a ground does."""
    if isinstance(ground, type) or not callable(getattr(ground, "measure", None)):
        checks.refuse(label, "a Plane, a HeightField, a TriangleGround or None", ground)
    return cast(Ground, ground)


def measurable(label: str, points: npt.ArrayLike) -> FloatArray:
    """Points (k, 3) as a ground can measure them."""
    return array_checks.array(label, points, (None, 3), finite=False, unit="m")


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A fixed half-space with Coulomb friction.

    Attributes:
        friction: Coulomb coefficient mu, >= 0.
        normal: outward unit normal (normalised on construction).
        offset: the plane is { p : normal . p = offset }, m.
        friction_map: factors on the friction by place; None where it is the same everywhere.
    """

    friction: float = 0.8
    normal: Vector = (0.0, 0.0, 1.0)
    offset: float = 0.0
    friction_map: FrictionMap | None = None

    def __post_init__(self) -> None:
        """Normalise the normal and refuse a negative friction."""
        x, y, z = checks.direction("Plane.normal", self.normal)
        checks.keep(
            self,
            friction=checks.number("Plane.friction", self.friction, low=0.0),
            normal=(x, y, z),
            offset=checks.number("Plane.offset", self.offset, unit="m"),
            friction_map=checked_map("Plane.friction_map", self.friction_map),
        )

    def measure(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distances (k,) m of points (k, 3), and the normal for each of them (k, 3)."""
        points = measurable("points of Plane.measure", points)
        normals = np.empty((len(points), 3))
        normals[:] = self.normal
        return points @ np.array(self.normal) - self.offset, normals
