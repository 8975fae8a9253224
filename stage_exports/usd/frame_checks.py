"""A frame is checked before it is stored, and copied so that nobody else changes it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.contact_mode import ContactMode
from warp_softbody.errors import InputError
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.conventions import TIME_CODE_DIGITS
from warp_softbody.world.frame import ContactSample, Frame

LARGEST = float(np.finfo(np.float32).max)
"""What single precision, in which everything is stored, can hold."""

NOTHING = ContactSample()


def checked_time_code(frame: Frame, fps: float, last: float) -> float:
    """The time code at which a frame stands.

    Args:
        frame: whose time counts.
        fps: time codes per second.
        last: of the frame before.

    Raises:
        InputError: it is no frame, or its time is not a later one.
    """
    if not isinstance(frame, Frame):
        raise InputError(f"a stage is made of Frames, got {type(frame).__name__}")
    try:
        code = round(float(frame.time) * fps, TIME_CODE_DIGITS)
    except (TypeError, ValueError):
        code = math.nan
    if not math.isfinite(code):
        raise InputError(f"frame {frame.index}: time must be a finite number, got {frame.time!r}")
    if not code > last:
        raise InputError(
            f"frame {frame.index} at {frame.time!r} s is not later than the last one, "
            f"which is at {last / fps:g} s"
        )
    return code


def owned(frame: Frame, bodies: Sequence[StagedBody]) -> Frame:
    """A copy of a frame, checked against the bodies.

    Raises:
        InputError: an array is not one of this scene, or holds what cannot be stored.
    """
    last = bodies[-1]
    place = f"frame {frame.index}"
    nodes = last.nodes.stop
    return unchecked_copy(
        frame,
        positions=_numbers(place, "positions", frame.positions, (nodes, 3)),
        velocities=_numbers(place, "velocities", frame.velocities, (nodes, 3)),
        activations=_numbers(place, "activations", frame.activations, (last.segments.stop,)),
        fiber_points=_numbers(place, "fiber_points", frame.fiber_points, (last.vertices.stop, 3)),
        contacts=_contacts(place, "contact", frame.contacts, nodes, named=not last.alone),
        patches=_contacts(place, "patch", frame.patches, None, named=False),
    )


def _contacts(
    place: str, kind: str, contacts: ContactSample, nodes: int | None, *, named: bool
) -> ContactSample:
    """A copy of contacts; with one body it is clear whose they are, so they need no numbers."""
    count = len(contacts.points)
    if not count and not len(contacts.nodes):
        return unchecked_copy(NOTHING, names=contacts.names)
    named = named or len(contacts.nodes) > 0
    own = unchecked_copy(
        contacts,
        nodes=_wholes(place, f"{kind} nodes", contacts.nodes, (count if named else 0,)),
        points=_numbers(place, f"{kind} points", contacts.points, (count, 3)),
        modes=_wholes(place, f"{kind} modes", contacts.modes, (count,)),
        forces=_numbers(place, f"{kind} forces", contacts.forces, (count, 3)),
        bodies=_wholes(place, f"{kind} bodies", contacts.bodies, (count,)),
        partners=_wholes(place, f"{kind} partners", contacts.partners, (count,)),
        partner_nodes=_wholes(place, f"{kind} partner nodes", contacts.partner_nodes, (count, 3)),
        partner_weights=_numbers(
            place, f"{kind} partner weights", contacts.partner_weights, (count, 3)
        ),
    )
    if nodes is not None and np.any((own.nodes < 0) | (own.nodes >= nodes)):
        raise InputError(f"{place}: a contact node is not one of the {nodes} nodes")
    known = [int(mode) for mode in ContactMode]
    if count and not (own.modes.min() >= known[0] and own.modes.max() <= known[-1]):
        raise InputError(f"{place}: {kind} modes must be from {known}, got {own.modes.tolist()}")
    return own


def _numbers(
    place: str, name: str, values: npt.ArrayLike, shape: tuple[int, ...]
) -> npt.NDArray[np.float64]:
    try:
        own = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{place}: {name} must be numbers: {error}") from error
    _check_shape(place, name, own, shape)
    # one product says of nearly all that they can be stored, in a tenth of the time
    if not np.vdot(own, own) <= LARGEST and own.size and not np.abs(own).max() <= LARGEST:
        if not np.isfinite(own).all():
            raise InputError(f"{place}: {name} holds a number that is not finite")
        raise InputError(f"{place}: {name} holds a number beyond single precision")
    return own


def _wholes(
    place: str, name: str, values: npt.ArrayLike, shape: tuple[int, ...]
) -> npt.NDArray[np.int32]:
    given = np.asarray(values)
    if given.size and given.dtype.kind not in "iu":
        raise InputError(f"{place}: {name} must be whole numbers, got {given.dtype}")
    _check_shape(place, name, given, shape)
    return np.array(given, dtype=np.int32)


def _check_shape(place: str, name: str, array: npt.NDArray[Any], shape: tuple[int, ...]) -> None:
    if array.shape != shape:
        raise InputError(f"{place}: {name} must have the shape {shape}, got {array.shape}")
