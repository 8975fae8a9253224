"""Arrays of a stage are checked to be what a writer stores and widened to double precision."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.contact_mode import ContactMode
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.world.frame import ContactSample

if TYPE_CHECKING:
    from warp_softbody.stage_exports.usd.extraction import StoredContacts

Stored = npt.NDArray[Any]


def numbers(name: str, stored: Stored, shape: tuple[int, ...]) -> FloatArray:
    """Finite numbers of a shape, in which -1 is any number but none.

    Raises:
        ValueError: they are not; the sentence's subject is ``name``.
    """
    array = np.asarray(stored, dtype=np.float64)
    fits = array.ndim == len(shape) and all(
        size == wanted or (wanted == -1 and size > 0)
        for size, wanted in zip(array.shape, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if size == -1 else str(size) for size in shape)
        raise ValueError(f"{name} have the shape {array.shape} and not ({wanted})")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} hold a number that is not finite")
    return array


def indices(name: str, stored: Stored, corners: int, points: int) -> IntArray:
    """(k, corners) indices of points, at least one row.

    Raises:
        ValueError: they are not.
    """
    if stored.dtype.kind not in "iu" or stored.size == 0 or stored.size % corners:
        raise ValueError(f"{name} are not rows of {corners} whole numbers")
    if stored.min() < 0 or stored.max() >= points:
        wrong = stored.min() if stored.min() < 0 else stored.max()
        raise ValueError(f"{name} name the point {wrong} of {points}")
    return np.array(stored, dtype=np.int32).reshape(-1, corners)


def time_codes(stored: Stored) -> FloatArray:
    """(f,) codes that increase.

    Raises:
        ValueError: they do not.
    """
    codes = numbers("time codes", stored, (-1,))
    if np.any(np.diff(codes) <= 0.0):
        raise ValueError("time codes do not increase")
    return codes


def positive(name: str, value: float) -> float:
    """A finite number above zero.

    Raises:
        ValueError: it is none.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} must be a positive number, got {value!r}")
    return value


def activations(
    points: Stored | None, stored: Stored | None, frames: int
) -> tuple[FloatArray, FloatArray]:
    """Ends (f, s, 2, 3) and activations (f, s) of muscle segments; none where nothing is stored.

    Raises:
        ValueError: they do not fit together.
    """
    if points is None or stored is None:
        return np.zeros((frames, 0, 2, 3)), np.zeros((frames, 0))
    own = numbers("activations", stored, (frames, -1))
    ends = numbers("points of fibers", points, (frames, 2 * own.shape[1], 3))
    return ends.reshape(frames, -1, 2, 3), own


def contacts(name: str, stored: StoredContacts | None, frames: int) -> tuple[ContactSample, ...]:
    """One sample a frame; empty ones where nothing is stored.

    Raises:
        ValueError: points, modes and forces of a frame do not fit together.
    """
    if stored is None:
        return tuple(ContactSample() for _ in range(frames))
    rows = zip(stored["points"], stored["modes"], stored["forces"], stored["partners"], strict=True)
    return tuple(_contact(name, *row) for row in rows)


def _contact(
    name: str, points: Stored, modes: Stored, forces: Stored, partners: dict[str, Stored]
) -> ContactSample:
    count = points.size // 3
    if modes.shape != (count,) or not np.isin(modes, [int(mode) for mode in ContactMode]).all():
        raise ValueError(f"{name} have modes that are none")
    return ContactSample(
        points=numbers(f"points of {name}", points.reshape(-1, 3), (count, 3)),
        modes=np.array(modes, dtype=np.int32),
        forces=numbers(f"forces of {name}", forces.reshape(-1, 3), (count, 3)),
        **_partners(name, count, partners),
    )


def _partners(name: str, count: int, stored: dict[str, Stored]) -> dict[str, Any]:
    """Nodes and other sides of ``count`` contacts, where they are stored.

    Raises:
        ValueError: they do not fit the contacts.
    """
    found: dict[str, Any] = {}
    for field, array in stored.items():
        shape = (count, 3) if field in ("partner_nodes", "partner_weights") else (count,)
        if array.size != int(np.prod(shape)):
            raise ValueError(f"{name} have {array.size} of {field}, not {int(np.prod(shape))}")
        given = numbers(f"{field} of {name}", array.reshape(shape), shape)
        found[field] = given if field == "partner_weights" else given.astype(np.int32)
    return found
