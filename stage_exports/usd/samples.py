"""A run of frames is stored as a layer that holds time samples and nothing else."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from pxr import Sdf

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.palette import activation_steps
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.prims import contact_width, fiber_width
from warp_softbody.world.frame import ContactSample, Frame

_TYPES = {
    conventions.TRANSLATION: Sdf.ValueTypeNames.Double3,
    "points": Sdf.ValueTypeNames.Point3fArray,
    conventions.VELOCITY: Sdf.ValueTypeNames.Vector3fArray,
    "extent": Sdf.ValueTypeNames.Float3Array,
    "widths": Sdf.ValueTypeNames.FloatArray,
    conventions.COLOR_INDICES: Sdf.ValueTypeNames.IntArray,
    conventions.ACTIVATION: Sdf.ValueTypeNames.FloatArray,
    conventions.CONTACT_MODE: Sdf.ValueTypeNames.IntArray,
    conventions.CONTACT_FORCE: Sdf.ValueTypeNames.Vector3fArray,
    conventions.CONTACT_NODE: Sdf.ValueTypeNames.IntArray,
    conventions.CONTACT_PARTNER: Sdf.ValueTypeNames.IntArray,
    conventions.CONTACT_PARTNER_NODES: Sdf.ValueTypeNames.Int3Array,
    conventions.CONTACT_PARTNER_WEIGHTS: Sdf.ValueTypeNames.Float3Array,
}


class Sample(NamedTuple):
    """One value of one attribute at the time of a frame."""

    prim: str
    attribute: str
    value: Any


class TimedFrame(NamedTuple):
    """A frame, the time code at which it stands, and a camera that moves."""

    time_code: float
    frame: Frame
    camera: Camera | None = None


def sample_layer(bodies: Sequence[StagedBody], frames: Sequence[TimedFrame]) -> Any:
    """Overs of the moving attributes, with the first and last time code in the layer's clock."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    series: dict[tuple[str, str], dict[float, Any]] = defaultdict(dict)
    for time_code, frame, camera in frames:
        if camera is not None:
            # a camera that moves keeps its direction
            eye = values.place(camera)
            series[conventions.CAMERA, conventions.TRANSLATION][time_code] = eye
        for body in bodies:
            path = conventions.character_path(body.character.name)
            for sample in frame_samples(body, body.share(frame)):
                series[f"{path}/{sample.prim}", sample.attribute][time_code] = sample.value
    with Sdf.ChangeBlock():
        for (path, name), samples in series.items():
            prim = Sdf.CreatePrimInLayer(layer, path)
            place = Sdf.AttributeSpec(prim, name, _TYPES[name]).path
            for code, value in samples.items():
                layer.SetTimeSample(place, code, value)
    layer.startTimeCode = frames[0].time_code
    layer.endTimeCode = frames[-1].time_code
    return layer


def frame_samples(body: StagedBody, frame: Frame) -> Iterator[Sample]:
    """Every value that a body's share of a frame adds to its prim."""
    skin = body.layout.skin_at(frame.positions)
    yield from _moving_points(conventions.SKIN, skin)
    yield from _moving_points(conventions.TETS, frame.positions)
    yield Sample(conventions.TETS, conventions.VELOCITY, values.vectors(frame.velocities))
    if len(body.layout.segment_ends):
        yield from _fiber_samples(body, frame)
    if body.touches:
        shown = drawable(frame.contacts, frame.positions)
        yield from _contact_samples(conventions.CONTACTS, body, frame.contacts, shown)
        yield from _partner_samples(conventions.CONTACTS, shown)
    if body.plans:
        shown = drawable(frame.patches, frame.positions)
        yield from _contact_samples(conventions.PATCHES, body, frame.patches, shown)


def _moving_points(prim: str, positions: FloatArray) -> Iterator[Sample]:
    """Points without ``velocities``, along which readers would extrapolate through an impact."""
    points = values.vectors(positions)
    yield Sample(prim, "points", points)
    yield Sample(prim, "extent", values.extent(points))


def _fiber_samples(body: StagedBody, frame: Frame) -> Iterator[Sample]:
    points = values.vectors(frame.fiber_points[body.layout.segment_ends.reshape(-1)])
    colors = activation_steps(frame.activations)
    yield Sample(conventions.FIBERS, "points", points)
    yield Sample(conventions.FIBERS, "extent", values.extent(points, fiber_width(body)))
    yield Sample(conventions.FIBERS, conventions.ACTIVATION, values.floats(frame.activations))
    yield Sample(conventions.FIBERS, conventions.COLOR_INDICES, values.integers(colors))


def drawable(contacts: ContactSample, positions: FloatArray) -> ContactSample:
    """The contacts, or one without width and force amid the body where there is none.

    Blender's Cycles ends on points without a point.
    """
    if len(contacts.points):
        return contacts
    return ContactSample(
        points=positions.mean(axis=0, keepdims=True),
        modes=np.zeros(1, dtype=np.int32),
        forces=np.zeros((1, 3)),
    )


def _contact_samples(
    prim: str, body: StagedBody, given: ContactSample, contacts: ContactSample
) -> Iterator[Sample]:
    points = values.vectors(np.asarray(contacts.points).reshape(-1, 3))
    width = contact_width(body) if len(given.points) else 0.0
    yield Sample(prim, "points", points)
    yield Sample(prim, "extent", values.extent(points, width))
    yield Sample(prim, "widths", values.floats(np.full(len(points), width)))
    yield Sample(prim, conventions.COLOR_INDICES, values.integers(contacts.modes))
    yield Sample(prim, conventions.CONTACT_MODE, values.integers(contacts.modes))
    yield Sample(prim, conventions.CONTACT_FORCE, values.vectors(contacts.forces))


def _partner_samples(prim: str, contacts: ContactSample) -> Iterator[Sample]:
    """Whose contacts: the node, the body on the other side, and where on it."""
    nodes = contacts.nodes
    if len(nodes) != len(contacts.points):
        nodes = np.full(len(contacts.points), -1, dtype=np.int32)
    yield Sample(prim, conventions.CONTACT_NODE, values.integers(nodes))
    yield Sample(prim, conventions.CONTACT_PARTNER, values.integers(contacts.partners))
    corners, weights = contacts.partner_nodes, contacts.partner_weights
    yield Sample(prim, conventions.CONTACT_PARTNER_NODES, values.triples(corners))
    yield Sample(prim, conventions.CONTACT_PARTNER_WEIGHTS, values.vectors(weights))
