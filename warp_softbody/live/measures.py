"""Numbers of a character at one time: centre of mass, momenta, capture point, what it rests on."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray, cross_rows
from warp_softbody.world.frame import ContactSample
from warp_softbody.world.scene import STANDARD_GRAVITY

AXES = ("x", "y", "z")

PLACES = tuple(f"com.{axis}" for axis in AXES) + tuple(f"velocity.{axis}" for axis in AXES)
MOMENTA = tuple(f"momentum.{axis}" for axis in AXES) + tuple(f"spin.{axis}" for axis in AXES)
OTHERS = (*(f"capture.{axis}" for axis in AXES), "support", "contraction")


class CharacterMeasures:
    """Measures a character frame by frame.

    The centre of mass is in m, its velocity in m/s, the momentum in N s and the angular momentum
    about the centre of mass, called spin, in N m s. The capture point is where a point mass on a
    massless leg would have to step to come to rest: the centre of mass on the ground, ahead by its
    velocity times sqrt(height / gravity) (Pratt et al., Humanoids 2006). The support is the sum of
    the contact forces along the ground's normal, N, and the contraction the mean of 1 - l_d / l_0.

    Attributes:
        names: of the numbers, in their order.
        weight: N, of the body in its gravity, in the standard one where there is none; None where
            the mass is not known.
    """

    def __init__(
        self,
        shares: FloatArray,
        mass: float | None,
        *,
        gravity: tuple[float, float, float] | None,
        normal: tuple[float, float, float] | None,
        offset: float | None,
    ) -> None:
        """Of a body.

        Args:
            shares: (n,) of the mass that each node bears, adding up to one.
            mass: kg; None where it is not known, and momenta with it.
            gravity: m/s^2; None where it is not known, and the capture point with it.
            normal: of the ground; None without one.
            offset: of a plane along its normal, m; None on uneven ground, which has no height, and
                so no capture point, of its own.
        """
        self._shares = shares
        self._mass = mass
        self._normal = None if normal is None else np.array(normal)
        self._offset = offset
        self.set_gravity(gravity)
        self.names = (*PLACES, *(() if mass is None else MOMENTA), *OTHERS)
        fall = self._fall or STANDARD_GRAVITY
        self.weight = None if mass is None else mass * fall

    def set_gravity(self, gravity: tuple[float, float, float] | None) -> None:
        """Measure under another gravity from now on, m/s^2."""
        self._fall = 0.0 if gravity is None else float(np.linalg.norm(gravity))

    def of(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        contraction: FloatArray,
        contacts: ContactSample,
    ) -> FloatArray:
        """(k,) the numbers, by ``names``; NaN for a capture point that there is not.

        Args:
            positions: (n, 3) m, of the character's nodes.
            velocities: (n, 3) m/s.
            contraction: (s,) 1 - l_d / l_0.
            contacts: on the character.
        """
        center = self._shares @ positions
        velocity = self._shares @ velocities
        found = [center, velocity]
        if self._mass is not None:
            moved = cross_rows(positions - center, velocities)
            found += [self._mass * velocity, self._mass * (self._shares @ moved)]
        mean = float(contraction.mean()) if len(contraction) else 0.0
        others = np.array([self._support(contacts.forces), mean])
        return np.concatenate([*found, self._capture_point(center, velocity), others])

    def _capture_point(self, center: FloatArray, velocity: FloatArray) -> FloatArray:
        normal = self._normal
        if normal is None or self._offset is None or not self._fall:
            return np.full(3, np.nan)
        height = float(normal @ center) - self._offset
        if height <= 0.0:
            return np.full(3, np.nan)
        along = velocity - (normal @ velocity) * normal
        below = center - height * normal
        return np.asarray(below + along * np.sqrt(height / self._fall))

    def _support(self, forces: FloatArray) -> float:
        up = np.array((0.0, 0.0, 1.0)) if self._normal is None else self._normal
        return float((forces @ up).sum())
