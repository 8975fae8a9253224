"""What a body can stand on."""

from __future__ import annotations

import math
from dataclasses import dataclass

from warp_softbody.errors import InputError


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A fixed half-space with Coulomb friction.

    Attributes:
        friction: Coulomb coefficient mu, >= 0.
        normal: outward unit normal (normalised on construction).
        offset: the plane is { p : normal . p = offset }, m.
    """

    friction: float = 0.8
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    offset: float = 0.0

    def __post_init__(self) -> None:
        """Normalise the normal and refuse a negative friction."""
        if not (math.isfinite(self.friction) and self.friction >= 0.0):
            raise InputError(
                f"plane friction must be finite and not negative, got {self.friction!r}"
            )
        length = math.sqrt(sum(component * component for component in self.normal))
        if not (math.isfinite(length) and length > 0.0):
            raise InputError(f"plane normal must be a finite, nonzero vector, got {self.normal!r}")
        x, y, z = (component / length for component in self.normal)
        object.__setattr__(self, "normal", (x, y, z))
        if not math.isfinite(self.offset):
            raise InputError(f"plane offset must be finite, got {self.offset!r}")
