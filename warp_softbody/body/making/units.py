"""Units and axes of a surface: it is brought to metres, upright along z and facing +x."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}
"""Metres in each unit of length."""

AXES = {
    sign + name: (1.0 if sign != "-" else -1.0) * np.eye(3)[axis]
    for axis, name in enumerate("xyz")
    for sign in ("", "+", "-")
}
"""Directions by name."""


def metres_per_unit(unit: object) -> float:
    """Metres in a unit, given by its name or as a number of metres."""
    if isinstance(unit, str):
        return UNITS[checks.choice("unit of a surface", unit, UNITS)]
    return checks.number("unit of a surface", unit, above=0.0, unit="m")


def upright(up: object, forward: object | None) -> FloatArray:
    """Rotation (3, 3) that takes the direction ``up`` to +z and ``forward`` to +x.

    Args:
        up: "x", "-y", "z", ...
        forward: likewise; None for one that is perpendicular to ``up``: x, or z where up is x.

    Raises:
        InputError: a name that is none, or directions along one axis.
    """
    z = AXES[checks.choice("up of a surface", up, AXES)]
    if forward is None:
        forward = "z" if z[0] else "x"
    x = AXES[checks.choice("forward of a surface", forward, AXES)]
    if x @ z:
        raise InputError(
            f"forward of a surface must be perpendicular to up, but both are along one axis: "
            f"up {up!r} and forward {forward!r}"
        )
    return np.stack([x, np.cross(z, x), z])
