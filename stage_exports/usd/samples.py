"""A run of frames is stored as a layer that holds time samples and nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from pxr import Sdf

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.creases import point_normals
from warp_softbody.stage_exports.palette import activation_colors, mode_colors
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.prims import contact_width, fiber_width
from warp_softbody.world.frame import ContactSample, Frame

_TYPES = {
    "points": Sdf.ValueTypeNames.Point3fArray,
    "normals": Sdf.ValueTypeNames.Normal3fArray,
    conventions.VELOCITY: Sdf.ValueTypeNames.Vector3fArray,
    "extent": Sdf.ValueTypeNames.Float3Array,
    "widths": Sdf.ValueTypeNames.FloatArray,
    "primvars:displayColor": Sdf.ValueTypeNames.Color3fArray,
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
    with Sdf.ChangeBlock():
        for time_code, frame, camera in frames:
            if camera is not None:
                _set_camera(layer, time_code, camera)
            for body in bodies:
                place = conventions.character_path(body.character.name)
                for sample in frame_samples(body, body.share(frame)):
                    _set(layer, place, time_code, sample)
    layer.startTimeCode = frames[0].time_code
    layer.endTimeCode = frames[-1].time_code
    return layer


def _set(layer: Any, body: str, time_code: float, sample: Sample) -> None:
    path = f"{body}/{sample.prim}"
    attribute = layer.GetAttributeAtPath(f"{path}.{sample.attribute}")
    if attribute is None:
        prim = Sdf.CreatePrimInLayer(layer, path)
        attribute = Sdf.AttributeSpec(prim, sample.attribute, _TYPES[sample.attribute])
    layer.SetTimeSample(attribute.path, time_code, sample.value)


def _set_camera(layer: Any, time_code: float, camera: Camera) -> None:
    path = f"{conventions.CAMERA}.{conventions.TRANSFORM}"
    if layer.GetAttributeAtPath(path) is None:
        prim = Sdf.CreatePrimInLayer(layer, conventions.CAMERA)
        Sdf.AttributeSpec(prim, conventions.TRANSFORM, Sdf.ValueTypeNames.Matrix4d)
    layer.SetTimeSample(path, time_code, values.placed(camera))


def frame_samples(body: StagedBody, frame: Frame) -> Iterator[Sample]:
    """Every value that a body's share of a frame adds to its prim."""
    skin = frame.positions[body.layout.skin_nodes]
    yield from _moving_points(conventions.SKIN, skin)
    normals = values.vectors(point_normals(body.layout.skin_faces, skin))
    yield Sample(conventions.SKIN, "normals", normals)
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
    colors = activation_colors(frame.activations)
    yield Sample(conventions.FIBERS, "points", points)
    yield Sample(conventions.FIBERS, "extent", values.extent(points, fiber_width(body)))
    yield Sample(conventions.FIBERS, conventions.ACTIVATION, values.floats(frame.activations))
    yield Sample(conventions.FIBERS, "primvars:displayColor", values.vectors(colors))


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
    yield Sample(prim, "primvars:displayColor", values.vectors(mode_colors(contacts.modes)))
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
