"""A run of frames is stored as a layer that holds time samples and nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from pxr import Sdf

from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.series import Series, body_series
from warp_softbody.world.frame import Frame

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


class TimedFrame(NamedTuple):
    """A frame, the time code at which it stands, and a camera that moves."""

    time_code: float
    frame: Frame
    camera: Camera | None = None


def sample_layer(bodies: Sequence[StagedBody], frames: Sequence[TimedFrame]) -> Any:
    """Overs of the moving attributes, with the first and last time code in the layer's clock."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    codes = [own.time_code for own in frames]
    with Sdf.ChangeBlock():
        for prim, name, samples in _all_series(bodies, frames):
            place = Sdf.AttributeSpec(Sdf.CreatePrimInLayer(layer, prim), name, _TYPES[name]).path
            for code, value in zip(codes, samples, strict=True):
                layer.SetTimeSample(place, code, value)
    layer.startTimeCode = codes[0]
    layer.endTimeCode = codes[-1]
    return layer


def _all_series(bodies: Sequence[StagedBody], frames: Sequence[TimedFrame]) -> Iterator[Series]:
    cameras = [own.camera for own in frames if own.camera is not None]
    if cameras:
        # a camera that moves keeps its direction
        eyes = [values.place(camera) for camera in cameras]
        yield Series(conventions.CAMERA, conventions.TRANSLATION, eyes)
    for body in bodies:
        path = conventions.character_path(body.character.name)
        for series in body_series(body, [body.share(own.frame) for own in frames]):
            yield series._replace(prim=f"{path}/{series.prim}")
