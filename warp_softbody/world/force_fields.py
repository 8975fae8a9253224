"""Force fields act on every node of a scene, or of a region, by where it is and how it moves.

They are accelerations in closed form, as gravity is: a node of mass m feels m a(x, v, t).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.inputs import checks, input_kinds

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class ForceField(ABC):
    """What all fields have: where they act, and when.

    Attributes:
        region: name of a region of the scene, or of a body; None for all bodies.
        start: s.
        duration: s; endless where none is given.
        period: s, of a field that swings as the cosine from its start on; None for one that does
            not change.
    """

    region: str | None = None
    start: float = 0.0
    duration: float = math.inf
    period: float | None = None

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite."""
        owner = type(self).__name__
        if self.region is not None:
            input_kinds.name(f"{owner}.region", self.region)
        label = f"{owner}.duration"
        checks.keep(
            self,
            start=checks.number(f"{owner}.start", self.start, unit="s"),
            duration=checks.number(label, self.duration, low=0.0, unit="s", infinite=True),
        )
        if self.period is not None:
            period = checks.number(f"{owner}.period", self.period, above=0.0, unit="s")
            checks.keep(self, period=period)

    def strength(self, begin: float, end: float) -> float:
        """The mean factor of the field's size over the interval [begin, end] s."""
        first, last = max(begin, self.start), min(end, self.start + self.duration)
        if not last > first:
            return 0.0
        share = (last - first) / (end - begin)
        if self.period is None:
            return share
        rate = 2.0 * math.pi / self.period
        swing = math.sin(rate * (last - self.start)) - math.sin(rate * (first - self.start))
        return share * swing / (rate * (last - first))

    @abstractmethod
    def accelerations(
        self, positions: FloatArray, velocities: FloatArray, time_step: float
    ) -> FloatArray:
        """Accelerations (k, 3) m/s^2 at positions (k, 3) m and velocities (k, 3) m/s.

        They act throughout a step of ``time_step``, s.
        """


@dataclass(frozen=True, kw_only=True)
class UniformField(ForceField):
    """The same acceleration everywhere.

    Attributes:
        acceleration: m/s^2.
    """

    acceleration: Vector

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite."""
        super().__post_init__()
        label = "UniformField.acceleration"
        checks.keep(self, acceleration=checks.vector(label, self.acceleration, unit="m/s^2"))

    def accelerations(
        self, positions: FloatArray, velocities: FloatArray, time_step: float
    ) -> FloatArray:
        """See `ForceField`."""
        return np.broadcast_to(np.array(self.acceleration), positions.shape)


@dataclass(frozen=True, kw_only=True)
class RadialField(ForceField):
    """Away from a centre, or towards it, by a power of the distance.

    Attributes:
        center: m.
        acceleration: at ``distance``, m/s^2, away from the centre; negative towards it.
        distance: m; farther away the acceleration is that times ``(r / distance)^power``, nearer it
            falls to zero with r.
        power: -2 for what falls off as gravity of a planet does.
    """

    center: Vector
    acceleration: float
    distance: float
    power: float = -2.0

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite, and a distance that is not positive."""
        super().__post_init__()
        checks.settle(self, positive=("distance",), finite=("acceleration",), vectors=("center",))
        power = checks.number("RadialField.power", self.power, low=-8.0, high=8.0)
        checks.keep(self, power=power)

    def accelerations(
        self, positions: FloatArray, velocities: FloatArray, time_step: float
    ) -> FloatArray:
        """See `ForceField`."""
        arms = (positions - np.array(self.center)) / self.distance
        far = np.linalg.norm(arms, axis=1, keepdims=True)
        by_arm = np.maximum(far, 1.0) ** (self.power - 1.0)
        return np.asarray(self.acceleration * by_arm * arms)


@dataclass(frozen=True, kw_only=True)
class DragField(ForceField):
    """A medium that slows down what moves in it; one that moves itself is a wind.

    Attributes:
        rate: 1/s, at which the velocity relative to the medium decays.
        wind: velocity of the medium, m/s.
    """

    rate: float
    wind: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse numbers that are not finite, and a negative rate."""
        super().__post_init__()
        checks.settle(self, not_negative=("rate",), vectors=("wind",))

    def accelerations(
        self, positions: FloatArray, velocities: FloatArray, time_step: float
    ) -> FloatArray:
        """See `ForceField`; what decays by itself does so exactly, however long the step."""
        share = -math.expm1(-self.rate * time_step) / time_step
        return np.asarray(share * (np.array(self.wind) - velocities))
