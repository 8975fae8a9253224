"""Muscle fibres: polylines whose segments contract (docs/method.md section 2; paper section 4)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import InputError

FloatArray = npt.NDArray[np.float64]


class FiberKind(str, Enum):
    """What a fibre is for; the mechanics is the same for all kinds."""

    LONGITUDINAL = "longitudinal"
    RADIAL = "radial"
    HELICAL = "helical"


@dataclass(frozen=True, kw_only=True)
class Fiber:
    """One polyline of contractile segments in the rest pose.

    Attributes:
        vertices: (k, 3) m, k >= 2, in the rest frame; segment s joins vertices s and s + 1.
        kind: longitudinal, radial or helical.
        name: unique in its character.
    """

    vertices: FloatArray
    kind: FiberKind
    name: str

    def __post_init__(self) -> None:
        """Freeze a checked float64 copy of the vertices."""
        vertices = np.array(self.vertices, dtype=np.float64)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 2:
            raise InputError(
                f"fibre {self.name!r} needs vertices of shape (k >= 2, 3), got {vertices.shape}"
            )
        if not np.isfinite(vertices).all():
            raise InputError(f"fibre {self.name!r} has vertices that are not finite")
        if (np.linalg.norm(np.diff(vertices, axis=0), axis=1) <= 0.0).any():
            raise InputError(f"fibre {self.name!r} has a segment of length zero")
        vertices.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)

    @property
    def segment_count(self) -> int:
        """Number of segments, one degree of freedom each."""
        return len(self.vertices) - 1


@dataclass(frozen=True, kw_only=True)
class MuscleGroup:
    """Fibres that share one partition of unity over the tets.

    Segment j spreads its stress to tet i by w_ij = h(d_ij) / sum over the group of h,
    h(d) = exp(-d^2 / s^2), d_ij the rest distance from the segment to the tet's centre
    (paper eq. 6-7; the paper prints a positive exponent, a misprint).

    Attributes:
        fibers: the fibres of the group.
        strength: S, Pa: a segment held at rest length l_d feels the stress
            (S / l_0) max(0, l - l_d) along its direction, so k = S / l_0.
        kernel_width: s, m.
        name: unique in its character.
    """

    fibers: tuple[Fiber, ...]
    strength: float
    kernel_width: float
    name: str

    def __post_init__(self) -> None:
        """Refuse an empty group and values outside the physical range."""
        if not self.fibers:
            raise InputError(f"muscle group {self.name!r} has no fibres")
        for field in ("strength", "kernel_width"):
            value = getattr(self, field)
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(
                    f"muscle group {self.name!r}: {field} must be finite and positive, "
                    f"got {value!r}"
                )

    @property
    def segment_count(self) -> int:
        """Number of segments of all fibres."""
        return sum(fiber.segment_count for fiber in self.fibers)
