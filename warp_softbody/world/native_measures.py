"""Measures of a body for one step after another by native code."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.device.host_program import HostProgram
from warp_softbody.kernels.body_measures import COUNTS, NUMBERS, make_body_measures


class Momenta(NamedTuple):
    """What `BodyView` has under these names, and the rows (3, 3n) of the angular momentum."""

    center_of_mass: FloatArray
    linear_momentum: FloatArray
    angular_momentum: FloatArray
    turning: FloatArray


class BodyMeasures:
    """The momenta of a body, whose masses stay."""

    def __init__(self, masses: FloatArray) -> None:
        """Lay out the arrays for nodes of some masses (n,), kg."""
        program = _program(len(masses), 0)
        self._numbers = program.numbers
        self._numbers["masses"][...] = masses
        kernel = make_body_measures().find_momenta
        self._run = program.running(kernel, reads=[], writes=[])

    def momenta(self, positions: FloatArray, velocities: FloatArray) -> Momenta:
        """Of nodes at positions (n, 3), m, that move by velocities (n, 3), m/s."""
        numbers = self._numbers
        numbers["positions"][...] = positions
        numbers["velocities"][...] = velocities
        self._run()
        centre, linear, angular = numbers["momenta"].copy()
        turning = numbers["turning"].reshape(3, -1).copy()
        # views hand it out as it is
        turning.setflags(write=False)
        return Momenta(centre, linear, angular, turning)


class BaseArea:
    """The area of some triangles along the ground, and its gradient."""

    def __init__(
        self, count: int, triangles: npt.NDArray[np.integer], tangents: FloatArray
    ) -> None:
        """Of triangles (f, 3) among ``count`` nodes, along the tangents (2, 3) of the ground."""
        program = _program(count, len(triangles))
        self._numbers = program.numbers
        self._numbers["ground"][...] = tangents
        program.counts["triangles"][...] = triangles
        kernel = make_body_measures().find_area
        self._run = program.running(kernel, reads=[], writes=[])

    def find(self, positions: FloatArray) -> tuple[float, FloatArray]:
        """The area, m^2, and its gradient (n, 3) at positions (n, 3), m."""
        numbers = self._numbers
        numbers["positions"][...] = positions
        self._run()
        return float(numbers["area"][0]), numbers["gradient"].copy()


def _program(nodes: int, triangles: int) -> HostProgram:
    numbers = {name: shape(nodes, triangles) for name, shape in NUMBERS.items()}
    counts = {name: shape(nodes, triangles) for name, shape in COUNTS.items()}
    program = HostProgram(numbers, counts)
    program.counts["sizes"][...] = nodes, triangles
    return program
