"""What a body can stand on: what every ground answers, and the plane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError

FloatArray = npt.NDArray[np.float64]
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


def checked_friction(friction: float, name: str) -> None:
    """Refuse a friction that is negative or not finite."""
    if not (math.isfinite(friction) and friction >= 0.0):
        raise InputError(f"{name} friction must be finite and not negative, got {friction!r}")


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A fixed half-space with Coulomb friction.

    Attributes:
        friction: Coulomb coefficient mu, >= 0.
        normal: outward unit normal (normalised on construction).
        offset: the plane is { p : normal . p = offset }, m.
    """

    friction: float = 0.8
    normal: Vector = (0.0, 0.0, 1.0)
    offset: float = 0.0

    def __post_init__(self) -> None:
        """Normalise the normal and refuse a negative friction."""
        checked_friction(self.friction, "plane")
        length = math.sqrt(sum(component * component for component in self.normal))
        if not (math.isfinite(length) and length > 0.0):
            raise InputError(f"plane normal must be a finite, nonzero vector, got {self.normal!r}")
        x, y, z = (component / length for component in self.normal)
        object.__setattr__(self, "normal", (x, y, z))
        if not math.isfinite(self.offset):
            raise InputError(f"plane offset must be finite, got {self.offset!r}")

    def measure(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Signed distances (k,) m of points (k, 3), and the normal for each of them (k, 3)."""
        normals = np.empty((len(points), 3))
        normals[:] = self.normal
        return points @ np.array(self.normal) - self.offset, normals
