"""A run of frames is stored as a layer that holds time samples and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from pxr import Sdf

from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody, rest_frame
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

_CONVERSIONS = {
    Sdf.ValueTypeNames.Double3: values.triple,
    Sdf.ValueTypeNames.Point3fArray: values.vectors,
    Sdf.ValueTypeNames.Vector3fArray: values.vectors,
    Sdf.ValueTypeNames.Float3Array: values.vectors,
    Sdf.ValueTypeNames.FloatArray: values.floats,
    Sdf.ValueTypeNames.IntArray: values.integers,
    Sdf.ValueTypeNames.Int3Array: values.triples,
}


class TimedFrame(NamedTuple):
    """A frame, the time code at which it stands, and a camera that moves."""

    time_code: float
    frame: Frame
    camera: Camera | None = None


class SampleLayer:
    """Overs of the moving attributes of a run of frames, which may come in parts."""

    def __init__(self, layer: Any = None) -> None:
        """Hold no frame yet, or what a layer holds."""
        self._places: dict[tuple[str, str], Any] = {}
        self.layer: Any = Sdf.Layer.CreateAnonymous(".usda") if layer is None else layer

    def add(self, codes: Sequence[float], series: Sequence[Series]) -> None:
        """Store further frames, and the first and last time code in the layer's clock.

        The same frames may be stored again, as after an interrupt.
        """
        with Sdf.ChangeBlock():
            for prim, name, samples in series:
                place, convert = self._place(prim, name), _CONVERSIONS[_TYPES[name]]
                for code, value in zip(codes, samples, strict=True):
                    self.layer.SetTimeSample(place, code, convert(value))
        if not self.layer.HasStartTimeCode():
            self.layer.startTimeCode = codes[0]
        self.layer.endTimeCode = codes[-1]

    def _place(self, prim: str, name: str) -> Any:
        known = self._places.get((prim, name))
        if known is None:
            over = Sdf.CreatePrimInLayer(self.layer, prim)
            held = over.attributes.get(name) or Sdf.AttributeSpec(over, name, _TYPES[name])
            known = self._places[prim, name] = held.path
        return known


def all_series(bodies: Sequence[StagedBody], frames: Sequence[TimedFrame]) -> list[Series]:
    """What moves in the frames; the same attributes in the same order, whichever they are."""
    series = []
    cameras = [own.camera for own in frames if own.camera is not None]
    if cameras:
        # a camera that moves keeps its direction
        eyes = [np.asarray(camera.eye, dtype=np.float64) for camera in cameras]
        series.append(Series(conventions.CAMERA, conventions.TRANSLATION, eyes))
    for body in bodies:
        path = conventions.character_path(body.character.name)
        for one in body_series(body, [body.share(own.frame) for own in frames]):
            series.append(one._replace(prim=f"{path}/{one.prim}"))
    return series


def rest_series(bodies: Sequence[StagedBody], camera: Camera | None) -> list[Series]:
    """The same series of one frame in which all rests, with a camera if that moves."""
    return all_series(bodies, [TimedFrame(0.0, rest_frame(bodies), camera)])
