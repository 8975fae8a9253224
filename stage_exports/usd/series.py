"""What moves in a chunk of frames, attribute by attribute, made for all frames at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.palette import activation_steps
from warp_softbody.stage_exports.usd.prims import contact_width, fiber_width
from warp_softbody.world.frame import ContactSample, Frame

_ALONE = ContactSample(
    points=np.zeros((1, 3)), modes=np.zeros(1, dtype=np.int32), forces=np.zeros((1, 3))
)

Stored = npt.NDArray[np.float32]


Rows = Sequence[npt.NDArray[Any]] | npt.NDArray[Any]


class Series(NamedTuple):
    """The values of one attribute, one a frame, as they are stored."""

    prim: str
    attribute: str
    values: Rows


def body_series(body: StagedBody, frames: Sequence[Frame]) -> Iterator[Series]:
    """Every series that a body's prim takes from frames, which hold its share alone."""
    nodes = np.stack([frame.positions for frame in frames])
    yield from _moving_points(conventions.SKIN, _skins(body, nodes))
    yield from _moving_points(conventions.TETS, nodes)
    velocities = np.stack([frame.velocities for frame in frames])
    yield Series(conventions.TETS, conventions.VELOCITY, _stored(velocities))
    if len(body.layout.segment_ends):
        yield from _fiber_series(body, frames)
    if body.touches:
        shown = [drawable(frame.contacts, frame.positions) for frame in frames]
        given = np.array([len(frame.contacts.points) for frame in frames])
        yield from _contact_series(conventions.CONTACTS, body, given, shown)
        yield from _partner_series(conventions.CONTACTS, shown)
    if body.plans:
        shown = [drawable(frame.patches, frame.positions) for frame in frames]
        given = np.array([len(frame.patches.points) for frame in frames])
        yield from _contact_series(conventions.PATCHES, body, given, shown)


def drawable(contacts: ContactSample, positions: FloatArray) -> ContactSample:
    """The contacts, or one without width and force amid the body where there is none.

    Blender's Cycles ends on points without a point.
    """
    if len(contacts.points):
        return contacts
    return unchecked_copy(_ALONE, points=positions.mean(axis=0, keepdims=True))


def _skins(body: StagedBody, nodes: FloatArray) -> FloatArray:
    if body.layout.carriers is None:
        return np.asarray(nodes[:, body.layout.skin_nodes])
    return np.stack([body.layout.skin_at(positions) for positions in nodes])


def _moving_points(prim: str, positions: FloatArray, width: float = 0.0) -> Iterator[Series]:
    """Points without ``velocities``, along which readers would extrapolate through an impact."""
    points = _stored(positions)
    yield Series(prim, "points", points)
    yield Series(prim, "extent", _extents(points.min(axis=1), points.max(axis=1), width))


def _fiber_series(body: StagedBody, frames: Sequence[Frame]) -> Iterator[Series]:
    ends = body.layout.segment_ends.reshape(-1)
    points = np.stack([frame.fiber_points[ends] for frame in frames])
    activations = np.stack([frame.activations for frame in frames])
    yield from _moving_points(conventions.FIBERS, points, fiber_width(body))
    yield Series(conventions.FIBERS, conventions.ACTIVATION, _stored(activations))
    colors = activation_steps(activations)
    yield Series(conventions.FIBERS, conventions.COLOR_INDICES, colors)


def _contact_series(
    prim: str, body: StagedBody, given: npt.NDArray[np.int64], shown: Sequence[ContactSample]
) -> Iterator[Series]:
    ends = _row_ends(shown)
    points = np.concatenate([own.points for own in shown]).astype(np.float32)
    widths = np.where(given > 0, contact_width(body), 0.0).astype(np.float32)
    low = np.minimum.reduceat(points, ends[:-1])
    high = np.maximum.reduceat(points, ends[:-1])
    rows = list(pairwise(ends.tolist()))
    modes = [own.modes for own in shown]
    yield Series(prim, "points", [points[start:end] for start, end in rows])
    yield Series(prim, "extent", _extents(low, high, widths[:, None]))
    each = np.repeat(widths, np.diff(ends))
    yield Series(prim, "widths", [each[start:end] for start, end in rows])
    yield Series(prim, conventions.COLOR_INDICES, modes)
    yield Series(prim, conventions.CONTACT_MODE, modes)
    forces = [_stored(own.forces) for own in shown]
    yield Series(prim, conventions.CONTACT_FORCE, forces)


def _partner_series(prim: str, shown: Sequence[ContactSample]) -> Iterator[Series]:
    """Whose contacts: the node, the body on the other side, and where on it."""
    nodes = [_named_nodes(own) for own in shown]
    partners = [np.asarray(own.partners, dtype=np.int32) for own in shown]
    corners = [np.asarray(own.partner_nodes, dtype=np.int32) for own in shown]
    weights = [_stored(own.partner_weights) for own in shown]
    yield Series(prim, conventions.CONTACT_NODE, nodes)
    yield Series(prim, conventions.CONTACT_PARTNER, partners)
    yield Series(prim, conventions.CONTACT_PARTNER_NODES, corners)
    yield Series(prim, conventions.CONTACT_PARTNER_WEIGHTS, weights)


def _named_nodes(contacts: ContactSample) -> npt.NDArray[np.int32]:
    if len(contacts.nodes) == len(contacts.points):
        return contacts.nodes
    return np.full(len(contacts.points), -1, dtype=np.int32)


def _row_ends(shown: Sequence[ContactSample]) -> npt.NDArray[np.int64]:
    """(frames + 1,) where the contacts of each frame start among those of all."""
    return np.cumsum([0, *(len(own.points) for own in shown)])


def _stored(array: FloatArray) -> Stored:
    return array.astype(np.float32)


def _extents(low: Stored, high: Stored, width: float | Stored) -> Stored:
    """(frames, 2, 3) m, boxes of stored points; see `usd_arrays.extent`."""
    half = np.float32(0.5) * np.asarray(width, dtype=np.float32)
    return np.stack([low - half, high + half], axis=1)
