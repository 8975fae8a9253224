"""A take is read back from its file, so that motions are measured on what was exported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.skin import Skin, SkinMaterial
from warp_softbody.errors import InputError
from warp_softbody.stage_exports.conventions import IntArray
from warp_softbody.stage_exports.usd.grounds import read_ground
from warp_softbody.stage_exports.usd.isolation import apart
from warp_softbody.stage_exports.usd.stored_arrays import (
    activations,
    contacts,
    indices,
    numbers,
    positive,
    time_codes,
)
from warp_softbody.world.frame import ContactSample
from warp_softbody.world.ground import Ground

if TYPE_CHECKING:
    from warp_softbody.stage_exports.usd.extraction import StoredBody, StoredStage
    from warp_softbody.stage_exports.usd.stored_looks import StoredLook
from warp_softbody.inputs.records import Value


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Take(Value):
    """The motion of one body in NumPy; lengths are stored in single precision and widened here.

    Attributes:
        name: of the body.
        color: of the body, linear RGB.
        fps: time codes per second.
        times: (f,) s.
        rest: (n, 3) m, rest positions of the nodes.
        tets: (m, 4) node indices.
        tet_points: (f, n, 3) m.
        velocities: (f, n, 3) m/s.
        skin_rest: (k, 3) m, rest positions of the skin's points.
        skin_points: (f, k, 3) m.
        skin_faces: (t, 3) indices of skin points.
        skin: places in textures and materials of the faces, on the points at rest, of a body with
            a skin of its own; else None.
        fiber_points: (f, s, 2, 3) m, both ends of each muscle segment.
        activations: (f, s) l_d / l_0.
        contacts: touching nodes, one sample a frame; empty ones where there is nothing to touch.
            All that acts on the body; bodies on the other side in the order of `body_names`, nodes
            in their numbers. Stages of older versions do not tell nodes and other sides.
        patches: what the controller planned for its patches, without numbers.
        ground: what it moved on, or None.
        metadata: what the writer was given.
    """

    name: str
    color: tuple[float, float, float]
    fps: float
    times: FloatArray
    rest: FloatArray
    tets: IntArray
    tet_points: FloatArray
    velocities: FloatArray
    skin_rest: FloatArray
    skin_points: FloatArray
    skin_faces: IntArray
    skin: Skin | None
    fiber_points: FloatArray
    activations: FloatArray
    contacts: tuple[ContactSample, ...]
    patches: tuple[ContactSample, ...]
    ground: Ground | None
    metadata: Mapping[str, Any]

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.times)


def read_take(path: str | Path, name: str | None = None) -> Take:
    """Read one body of a stage that a `StageWriter` wrote, and refuse any other file.

    Args:
        path: the stage.
        name: of the body; None for the first, the scene's character.

    Raises:
        InputError: the file is none, is damaged, or holds no such body.
    """
    (take,) = _takes(path, name, every=False)
    return take


def read_takes(path: str | Path) -> tuple[Take, ...]:
    """All bodies of a stage, in the order of `body_names`.

    Raises:
        InputError: the file is none or is damaged.
    """
    takes = _takes(path, None, every=True)
    if any(not np.array_equal(take.times, takes[0].times) for take in takes):
        raise InputError(f"{str(path)!r} is damaged: its bodies have frames at different times")
    return takes


def body_names(path: str | Path) -> tuple[str, ...]:
    """Return the names of the bodies of a stage, the scene's character first.

    Raises:
        InputError: the file is none or is damaged.
    """
    return tuple(apart("extract_names", path))


def _takes(path: str | Path, name: str | None, *, every: bool) -> tuple[Take, ...]:
    stage = apart("extract", path, name, every)
    try:
        return tuple(_take(stage, body) for body in stage["bodies"])
    except ValueError as error:
        raise InputError(f"{str(path)!r} is damaged: {error}") from error


def _take(stage: StoredStage, body: StoredBody) -> Take:
    frames = len(body["codes"])
    rest = numbers("rest points", body["rest"], (-1, 3))
    skin = numbers("skin points", body["skin_rest"], (-1, 3))
    rate = positive("time codes per second", stage["fps"])
    faces = indices("faces of the skin", body["skin_faces"], 3, len(skin))
    fiber_points, activation = activations(body["fiber_points"], body["activations"], frames)
    return Take(
        name=body["name"],
        color=_triple(numbers("colors", body["color"], (-1, 3))[0]),
        fps=rate,
        times=time_codes(body["codes"]) / rate,
        rest=rest,
        tets=indices("tets", body["tets"], 4, len(rest)),
        tet_points=numbers("points of tets", body["tet_points"], (frames, len(rest), 3)),
        velocities=numbers("velocities", body["velocities"], (frames, len(rest), 3)),
        skin_rest=skin,
        skin_points=numbers("points of the skin", body["skin_points"], (frames, len(skin), 3)),
        skin_faces=faces,
        skin=_skin(skin, faces, body["look"]),
        fiber_points=fiber_points,
        activations=activation,
        contacts=contacts("contacts", body["contacts"], frames),
        patches=contacts("patches", body["patches"], frames),
        ground=read_ground(stage["ground"]),
        metadata=stage["metadata"],
    )


def _skin(points: FloatArray, faces: IntArray, look: StoredLook | None) -> Skin | None:
    """A body's own skin; what a damaged file has made of it is an InputError."""
    if look is None:
        return None
    places, corners = look["texture_points"], look["texture_faces"]
    texture: dict[str, Any] = {}
    if places is not None and corners is not None:
        texture = {
            "texture_points": numbers("places in the texture", places, (-1, 2)),
            "texture_faces": indices("corners in the texture", corners, 3, len(places)),
        }
    return Skin(
        points=points,
        faces=faces,
        materials=tuple(SkinMaterial(**one) for one in look["materials"]),
        face_materials=np.asarray(look["face_materials"]),
        **texture,
    )


def _triple(values: FloatArray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
