"""A scene: a character, the ground it stands on, and what pushes it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from warp_softbody.character import Character
from warp_softbody.errors import InputError
from warp_softbody.ground import Ground

STANDARD_GRAVITY = 9.81


@dataclass(frozen=True, kw_only=True)
class Push:
    """A force spread over a region of the character by nodal mass, for a while.

    Attributes:
        region: name of the region that is pushed.
        force: total force, N, (x, y, z).
        start: s.
        duration: s.
    """

    region: str
    force: tuple[float, float, float]
    start: float
    duration: float

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite and negative durations."""
        if not all(math.isfinite(value) for value in (*self.force, self.start, self.duration)):
            raise InputError(f"push on {self.region!r} holds a number that is not finite")
        if self.duration < 0.0:
            raise InputError(f"push duration must not be negative, got {self.duration!r}")

    def share(self, start: float, end: float) -> float:
        """Fraction of the interval [start, end] s during which the push acts."""
        overlap = min(end, self.start + self.duration) - max(start, self.start)
        return max(0.0, overlap) / (end - start)


@dataclass(frozen=True, kw_only=True)
class Scene:
    """What there is.

    Attributes:
        character: the body.
        ground: a plane, a height field or triangles; None for a body in free space.
        gravity: m/s^2.
        pushes: forces over time.
        initial_velocity: of every node, m/s.
    """

    character: Character
    ground: Ground | None = None
    gravity: tuple[float, float, float] = (0.0, 0.0, -STANDARD_GRAVITY)
    pushes: tuple[Push, ...] = ()
    initial_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check that every push names a region of the character."""
        for name in ("gravity", "initial_velocity"):
            if not all(math.isfinite(value) for value in getattr(self, name)):
                raise InputError(f"scene {name} must be finite, got {getattr(self, name)!r}")
        for push in self.pushes:
            self.character.region(push.region)
