"""Stages and pictures share this pinhole camera; z is up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray

# From where a body is seen: in front of it, a little to its right and above.
VIEW_DIRECTION = (-0.42, 1.0, -0.30)
VERTICAL_FIELD = 30.0


@dataclass(frozen=True, kw_only=True)
class Camera:
    """Where the camera stands.

    Attributes:
        eye: (3,) m.
        forward: (3,) unit vector along the view.
        vertical_field: full opening angle, degrees.
    """

    eye: FloatArray
    forward: FloatArray
    vertical_field: float = VERTICAL_FIELD

    @property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Unit vectors to the right and upwards in the picture."""
        return picture_axes(self.forward)

    @classmethod
    def framing(
        cls, lower: npt.ArrayLike, upper: npt.ArrayLike, *, aspect: float, margin: float = 1.06
    ) -> Camera:
        """The nearest camera that sees the whole box, with some air around it."""
        low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
        middle = (low + high) / 2.0
        return cls.looking(
            middle, cls.distance(low, high, aim=middle, aspect=aspect, margin=margin)
        )

    @classmethod
    def looking(cls, aim: FloatArray, distance: float) -> Camera:
        """A camera that looks at a point (3,) m from so far along the usual direction."""
        return cls(eye=aim - distance * _FORWARD, forward=_FORWARD)

    @staticmethod
    def distance(
        low: FloatArray, high: FloatArray, *, aim: FloatArray, aspect: float, margin: float
    ) -> float:
        """The least distance, m, from which one who looks at ``aim`` sees the whole box.

        The picture is ``aspect`` times as wide as high and reaches ``margin`` times as far.
        """
        across, above, ahead = _AXES @ (np.where(_CORNERS, high, low) - aim).T
        reach = np.maximum(np.abs(across) / aspect, np.abs(above)) * (margin / _SLOPE)
        return float((reach - ahead).max())


def picture_axes(forward: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Right and up of a picture taken along `forward` with z upwards."""
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward)


_FORWARD = np.asarray(np.array(VIEW_DIRECTION) / np.linalg.norm(VIEW_DIRECTION))
_AXES = np.stack([*picture_axes(_FORWARD), _FORWARD])
_CORNERS = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T == 1
_SLOPE = float(np.tan(np.radians(VERTICAL_FIELD) / 2.0))


def start_box(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The box of the start pose with room for the motion to come, on the floor it starts from."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(np.max(high - low))
    room = size * np.array([0.30, 0.10, 0.0])
    head = size * np.array([0.0, 0.0, 0.15])
    return low - room, high + room + head
