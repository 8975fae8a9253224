"""A muscle fibre is a polyline whose segments contract (docs/method.md section 2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import FrozenValue


class FiberKind(str, Enum):
    """The purpose of a fibre; the mechanics is the same for all kinds."""

    LONGITUDINAL = "longitudinal"
    RADIAL = "radial"
    HELICAL = "helical"

    @classmethod
    def _missing_(cls, value: object) -> FiberKind:
        """Refuse a value of none of the kinds."""
        return input_kinds.member("FiberKind", value, cls)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Fiber(FrozenValue):
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
        input_kinds.name("Fiber.name", self.name)
        label = f"Fiber.vertices of {self.name!r}"
        vertices = np.array(array_checks.array(label, self.vertices, (None, 3), unit="m"))
        if len(vertices) < 2:
            raise InputError(f"{label} must be two points or more, not {len(vertices)}")
        if (np.linalg.norm(np.diff(vertices, axis=0), axis=1) <= 0.0).any():
            raise InputError(f"fibre {self.name!r} has a segment of length zero")
        vertices.setflags(write=False)
        checks.keep(self, vertices=vertices)
        checks.keep(self, kind=input_kinds.member("Fiber.kind", self.kind, FiberKind))

    @property
    def segment_count(self) -> int:
        """Number of segments, one degree of freedom each."""
        return len(self.vertices) - 1


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MuscleGroup(FrozenValue):
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
        input_kinds.name("MuscleGroup.name", self.name)
        fibers = checks.items("MuscleGroup.fibers", self.fibers, Fiber)
        if not fibers:
            raise InputError(f"muscle group {self.name!r} has no fibres")
        input_kinds.distinct(f"fibres of the muscle group {self.name!r}", (f.name for f in fibers))
        strength = checks.number("MuscleGroup.strength", self.strength, above=0.0, unit="Pa")
        width = checks.number("MuscleGroup.kernel_width", self.kernel_width, above=0.0, unit="m")
        checks.keep(self, fibers=fibers, strength=strength, kernel_width=width)

    @property
    def segment_count(self) -> int:
        """Number of segments of all fibres."""
        return sum(fiber.segment_count for fiber in self.fibers)
