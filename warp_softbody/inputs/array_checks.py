"""Arrays are checked here, apart from other values, whose checks do without NumPy."""

from __future__ import annotations

from typing import cast

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs.checks import LARGEST, refuse

DOUBLE = np.dtype(np.float64)


def array(
    label: str,
    value: object,
    shape: tuple[int | None, ...] | None,
    *,
    finite: bool = True,
    unit: str = "",
) -> FloatArray:
    """Numbers as a float64 array; None in the shape stands for any length.

    An array that is float64 already is not copied. A shape of None takes any. Finite numbers are
    those that `checks.number` takes, below 1e30 in size.
    """
    if _is_ready(value, shape, finite):
        return cast(FloatArray, value)
    wanted = f"an array of {'finite ' if finite else ''}numbers{f' of {unit}' if unit else ''}"
    wanted += "" if shape is None else f" of shape {_shape(shape)}"
    try:
        given = np.asarray(value)
    except Exception:
        # rows of unequal length, or an object whose own conversion fails
        refuse(label, wanted, value)
    if given.dtype.kind not in "iuf" and not (given.size == 0 and given.dtype.kind != "O"):
        refuse(label, wanted, value)
    if not _fits(given.shape, shape):
        raise InputError(f"{label} must be {wanted}, not one of shape {given.shape}")
    with np.errstate(over="ignore"):
        numbers = np.asarray(given, dtype=np.float64)
    if finite and not np.isfinite(numbers).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(numbers))[0])
        raise InputError(f"{label} must be {wanted}, but it holds {numbers[place]} at {place}")
    if finite and np.abs(numbers).max(initial=0.0) > LARGEST:
        place = tuple(int(i) for i in np.argwhere(np.abs(numbers) > LARGEST)[0])
        raise InputError(
            f"{label} must be {wanted} and below {LARGEST:g} in size, "
            f"but it holds {numbers[place]} at {place}"
        )
    return numbers


def _is_ready(value: object, shape: tuple[int | None, ...] | None, finite: bool) -> bool:
    """Whether nothing is wrong with an array; told fast, for what is made in every step."""
    if type(value) is not np.ndarray or value.dtype is not DOUBLE:
        return False
    if shape is not None and value.shape != shape and not _fits(value.shape, shape):
        return False
    # where the sum of squares is so small, every number is; where it is not, all are looked at
    return not finite or bool(np.vdot(value, value) <= LARGEST * LARGEST)


def _fits(shape: tuple[int, ...], wanted: tuple[int | None, ...] | None) -> bool:
    if wanted is None:
        return True
    if len(shape) != len(wanted):
        return False
    for want, have in zip(wanted, shape, strict=True):
        if want is not None and want != have:
            return False
    return True


def _shape(shape: tuple[int | None, ...]) -> str:
    free = iter("nmklij")
    parts = ", ".join(next(free) if part is None else str(part) for part in shape)
    return f"({parts},)" if len(shape) == 1 else f"({parts})"
