"""A `MotionPath` says how what is held moves in time: shifts and turns between key times."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import FrozenValue

Vector = tuple[float, float, float]
Between = Literal["linear", "ease"]
BETWEENS: tuple[Between, ...] = get_args(Between)
Afterwards = Literal["hold", "repeat", "go_on"]
AFTERWARDS: tuple[Afterwards, ...] = get_args(Afterwards)

SAME_PLACE = 1e-9
"""Part of a path's reach by which its ends may differ where it repeats."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MotionPath(FrozenValue):
    """A rigid motion in time, from where the thing stands at rest.

    A point X moves to ``center + R (X - center) + shift``. Before the first time it is as at the
    first.

    Attributes:
        times: (k,) s, ascending.
        shifts: (k, 3) m, at those times; none where it only turns.
        degrees: (k,) of the turn at those times; none where it only shifts.
        axis: of the turn, right-handed.
        center: that stays where it is but for the shift, m; None for the mean of what is moved.
        between: "linear", at a constant speed from one time to the next, or "ease", which starts
            and stops at each with neither speed nor acceleration.
        afterwards: what follows the last time: "hold", "repeat" from the first, or "go_on" with the
            last velocity.
    """

    times: FloatArray
    shifts: FloatArray | None = None
    degrees: FloatArray | None = None
    axis: Vector = (0.0, 0.0, 1.0)
    center: Vector | None = None
    between: Between = "linear"
    afterwards: Afterwards = "hold"

    def __post_init__(self) -> None:
        """Check that there is a place for every time."""
        times = np.array(array_checks.array("MotionPath.times", self.times, (None,), unit="s"))
        if not len(times) or (np.diff(times) <= 0.0).any():
            raise InputError(
                "MotionPath.times must be times in s that ascend, at least one of them"
            )
        kept = {"times": times}
        for name, shape in (("shifts", (len(times), 3)), ("degrees", (len(times),))):
            given = getattr(self, name)
            values = np.zeros(shape) if given is None else given
            kept[name] = np.array(array_checks.array(f"MotionPath.{name}", values, shape))
        for array in kept.values():
            array.setflags(write=False)
        center = self.center
        checks.keep(
            self,
            **kept,
            axis=checks.direction("MotionPath.axis", self.axis),
            center=None if center is None else checks.vector("MotionPath.center", center, unit="m"),
            between=checks.choice("MotionPath.between", self.between, BETWEENS),
            afterwards=checks.choice("MotionPath.afterwards", self.afterwards, AFTERWARDS),
        )
        self._check_afterwards()

    def _check_afterwards(self) -> None:
        if self.afterwards != "hold" and len(self.times) < 2:
            raise InputError(f"MotionPath.afterwards {self.afterwards!r} needs two times or more")
        if self.afterwards == "go_on" and self.between == "ease":
            raise InputError(
                "MotionPath.afterwards 'go_on' goes with between 'linear': with 'ease' nothing is "
                "left of its speed at the last time"
            )
        shifts, degrees = self._arrays
        if self.afterwards == "repeat":
            apart = float(np.abs(shifts[-1] - shifts[0]).max())
            turned = math.remainder(float(degrees[-1] - degrees[0]), 360.0)
            if apart > SAME_PLACE * float(np.abs(shifts).max()) or abs(turned) > 1e-9 * 360.0:
                raise InputError(
                    "MotionPath.afterwards 'repeat' needs a path that ends where it begins, but "
                    f"its ends are {apart:g} m and {abs(turned):g} degrees apart"
                )

    @classmethod
    def straight(cls, velocity: Vector) -> MotionPath:
        """Return the path at a constant velocity, m/s, for ever."""
        step = checks.vector("velocity of MotionPath.straight", velocity, unit="m/s")
        return cls(
            times=np.array([0.0, 1.0]),
            shifts=np.array([(0.0, 0.0, 0.0), step]),
            afterwards="go_on",
        )

    @classmethod
    def spinning(cls, rate: float, axis: Vector, *, center: Vector | None = None) -> MotionPath:
        """Return the turn at a constant rate, degrees per second, for ever."""
        rate = checks.number("rate of MotionPath.spinning", rate, unit="degrees per second")
        return cls(
            times=np.array([0.0, 1.0]),
            degrees=np.array([0.0, rate]),
            axis=axis,
            center=center,
            afterwards="go_on",
        )

    @property
    def _arrays(self) -> tuple[FloatArray, FloatArray]:
        return np.asarray(self.shifts), np.asarray(self.degrees)

    @cached_property
    def largest_shift(self) -> float:
        """Size of the largest shift at the times given, m."""
        return float(np.linalg.norm(self._arrays[0], axis=1).max())

    def at(self, time: float) -> tuple[FloatArray, float]:
        """Shift (3,) m and angle, radians, at a time, s."""
        shifts, degrees = self._arrays
        first, last = float(self.times[0]), float(self.times[-1])
        if self.afterwards == "repeat" and time > first:
            time = first + math.fmod(time - first, last - first)
        if len(self.times) == 1 or time <= first:
            return shifts[0], math.radians(float(degrees[0]))
        index = min(int(np.searchsorted(self.times, time, side="right")), len(self.times) - 1) - 1
        begin, end = float(self.times[index]), float(self.times[index + 1])
        part = (time - begin) / (end - begin)
        if self.afterwards != "go_on":
            part = min(part, 1.0)
        if self.between == "ease":
            part = part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
        shift = shifts[index] + part * (shifts[index + 1] - shifts[index])
        turn = float(degrees[index] + part * (degrees[index + 1] - degrees[index]))
        return shift, math.radians(turn)

    def places(self, points: FloatArray, time: float) -> FloatArray:
        """Where points (k, 3) m are at a time, s."""
        shift, angle = self.at(time)
        if angle == 0.0:
            return np.asarray(points + shift)
        center = points.mean(axis=0) if self.center is None else np.array(self.center)
        arms = points - center
        # Rodrigues' formula
        axis = np.array(self.axis)
        across = np.cross(axis, arms)
        turned = arms + math.sin(angle) * across + (1.0 - math.cos(angle)) * np.cross(axis, across)
        return np.asarray(center + turned + shift)
