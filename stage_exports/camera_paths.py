"""How the camera moves with the bodies: it follows them, stands still, or stands where it is told.

A follower knows the past alone, so that a stage can be written while the run goes on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.stage_exports.camera import Camera, start_box

FOLLOW, STILL = "follow", "still"

REACTION = 0.35
"""s, time constant with which a follower takes up a body's place and speed."""

AIR, LEAST_AIR = 1.45, 1.05
"""Picture over body: wanted, and below which the camera steps back at once."""

CameraChoice = str | Camera | Sequence[float]
"""``"follow"``, ``"still"``, a `Camera`, or the place (x, y, z) m of one that looks at the start
pose."""


class CameraPath(Protocol):
    """Where the camera is at each frame, in the order of the frames."""

    @property
    def moves(self) -> bool:
        """Whether it is ever anywhere else than at first."""
        ...

    def at(self, time: float, points: FloatArray) -> Camera:
        """The camera for points (n, 3) m at a time, s, later than the one before."""
        ...


class StandingCamera:
    """A camera that stays where it is."""

    moves = False

    def __init__(self, camera: Camera) -> None:
        """Keep the camera."""
        self._camera = camera

    def at(self, time: float, points: FloatArray) -> Camera:
        """The same camera whenever."""
        return self._camera


@dataclass
class FollowingCamera:
    """A camera that keeps all points in the picture and their size about the same.

    It looks along one direction. Its aim follows the middle of the points' box with its speed, both
    taken up within ``REACTION``; where the box would leave the picture it steps back at once. At a
    time before the last one it begins anew.

    Attributes:
        aspect: width over height of the picture.
    """

    aspect: float
    _time: float | None = None

    moves = True

    def at(self, time: float, points: FloatArray) -> Camera:
        """The camera for points (n, 3) m at a time, s, usually later than the one before."""
        low, high = points.min(axis=0), points.max(axis=0)
        middle = (low + high) / 2.0
        wanted = Camera.distance(low, high, aim=middle, aspect=self.aspect, margin=AIR)
        if self._time is None or time < self._time:
            self._aim, self._distance = middle, wanted
            self._middle, self._speed = middle, np.zeros(3)
        elif time > self._time:
            step = time - self._time
            share = 1.0 - float(np.exp(-step / REACTION))
            self._speed = self._speed + share * ((middle - self._middle) / step - self._speed)
            ahead = self._aim + step * self._speed
            self._aim = ahead + share * (middle - ahead)
            self._distance += share * (wanted - self._distance)
            self._middle = middle
        needed = Camera.distance(low, high, aim=self._aim, aspect=self.aspect, margin=LEAST_AIR)
        self._distance = max(self._distance, needed)
        self._time = time
        return Camera.looking(self._aim, self._distance)


def camera_path(label: str, choice: object, points: FloatArray, aspect: float) -> CameraPath:
    """The path that a choice stands for, for bodies that start at points (n, 3) m.

    Raises:
        InputError: the choice is none of `CameraChoice`; the sentence names ``label``.
    """
    if isinstance(choice, Camera):
        return StandingCamera(choice)
    low, high = start_box(points)
    wanted = '"follow", "still", a Camera or the place (x, y, z) m of one'
    if isinstance(choice, str):
        if choice == STILL:
            return StandingCamera(Camera.framing(low, high, aspect=aspect))
        if choice == FOLLOW:
            return FollowingCamera(aspect)
        checks.refuse(label, wanted, choice)
    try:
        eye = np.array(checks.vector(label, choice, 3, unit="m"))
    except InputError:
        checks.refuse(label, wanted, choice)
    return StandingCamera(_towards(label, eye, (low + high) / 2.0))


def _towards(label: str, eye: FloatArray, goal: FloatArray) -> Camera:
    """A camera at a place that looks at another."""
    way = goal - eye
    if not np.hypot(way[0], way[1]) > 1e-3 * np.linalg.norm(way):
        checks.refuse(label, "not right above or below the bodies", eye.tolist())
    return Camera(eye=eye, forward=way / np.linalg.norm(way))
