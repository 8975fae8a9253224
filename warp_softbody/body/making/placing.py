"""Points of a file become metres, upright and on the floor."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.shape_regions import SOLE
from warp_softbody.body.making.units import metres_per_unit, upright
from warp_softbody.errors import InputError, MeshError
from warp_softbody.inputs import checks

PLAUSIBLE = (0.02, 20.0)
"""Heights, m, of bodies whose unit nobody has to tell."""


def to_metres(
    points: FloatArray,
    *,
    unit: str | float | None,
    height: float | None,
    up: str,
    forward: str | None,
    declared: str | None,
    source: str,
) -> FloatArray:
    """Matrix (3, 3) that takes points (n, 3) of a file to m, z up and x forward.

    Args:
        points: (n, 3) in the file's unit and axes.
        unit: as `Character.from_surface` takes it.
        height: likewise.
        up: likewise.
        forward: likewise.
        declared: the unit that the file's format has, or None.
        source: what sentences call the file.

    Raises:
        MeshError: the body is flat.
        InputError: values that do not go together, or a size that is hardly meant.
    """
    turn = upright(up, forward)
    tall = float(np.ptp(points @ turn[2]))
    if tall <= 0.0:
        raise MeshError(f"{source}: the body is flat along its up axis {up}")
    if height is not None:
        if unit is not None:
            raise InputError("a character's size is given by its unit or its height, not by both")
        return turn * (checks.number("height of a character", height, above=0.0, unit="m") / tall)
    factor = metres_per_unit(declared or "m" if unit is None else unit)
    low, high = PLAUSIBLE
    if unit is None and not low <= factor * tall <= high:
        raise InputError(
            f"{source}: a body {factor * tall:.3g} m high is hardly what is meant; give its unit "
            "('cm', 'mm', 'inch', ...; 'm' if it is) or its height in m"
        )
    return turn * factor


def floor_place(points: FloatArray) -> FloatArray:
    """The place (3,) m of points (n, 3) that comes to the origin when the body stands on the floor.

    It is below the middle of what stands there, at the height of the lowest point.
    """
    lowest = float(points[:, 2].min())
    stands = points[points[:, 2] - lowest < SOLE * float(np.ptp(points[:, 2])), :2]
    middle = 0.5 * (stands.min(axis=0) + stands.max(axis=0))
    return np.array([*middle, lowest])
