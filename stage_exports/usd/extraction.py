"""Arrays out of a stage, as they are stored; what they mean is checked by the reader.

It imports little, because it is also run in a process of its own (`isolation.py`).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Tf, Usd

from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.usd.stored_looks import StoredLook, stored_look, stored_value

Array = npt.NDArray[Any]
GROUND_NUMBERS = (
    conventions.GROUND_NORMAL,
    conventions.GROUND_OFFSET,
    conventions.GROUND_FRICTION,
    conventions.GROUND_HEIGHTS,
    conventions.GROUND_ROWS,
    conventions.GROUND_ORIGIN,
    conventions.GROUND_SPACING,
    conventions.FRICTION_FACTORS,
    conventions.FRICTION_ROWS,
    conventions.FRICTION_ORIGIN,
    conventions.FRICTION_SPACING,
)


PARTNER_PRIMVARS = {
    "nodes": conventions.CONTACT_NODE,
    "partners": conventions.CONTACT_PARTNER,
    "partner_nodes": conventions.CONTACT_PARTNER_NODES,
    "partner_weights": conventions.CONTACT_PARTNER_WEIGHTS,
}
"""Attributes by the field of `ContactSample` that they hold."""


class StoredContacts(TypedDict):
    """What the samples of a contact prim hold, one array a frame."""

    points: list[Array]
    modes: list[Array]
    forces: list[Array]
    partners: list[dict[str, Array]]


class StoredBody(TypedDict):
    """One body's prims; series have a first axis of frames."""

    name: str
    codes: Array
    color: Array
    rest: Array
    tets: Array
    tet_points: Array
    velocities: Array
    skin_rest: Array
    skin_points: Array
    skin_faces: Array
    look: StoredLook | None
    fiber_points: Array | None
    activations: Array | None
    contacts: StoredContacts | None
    patches: StoredContacts | None


class StoredStage(TypedDict):
    """Bodies of a stage, its clock, its ground by attribute, and its metadata."""

    bodies: list[StoredBody]
    fps: float
    ground: dict[str, Array] | None
    metadata: dict[str, str | float]


def extract(path: str, name: str | None, every: bool) -> StoredStage:
    """What a stage holds of one body, by default the first, or of every one.

    Raises:
        InputError: it has no such body, or the body lacks a value.
    """
    stage = open_stage(path)
    bodies = _bodies(stage, path)
    if name is not None and name not in bodies:
        wanted = checks.shown(name)
        raise InputError(f"{path!r} holds no body {wanted}; it holds: {', '.join(bodies)}")
    chosen = list(bodies) if every else [name or next(iter(bodies))]
    data = stage.GetRootLayer().customLayerData.get(conventions.METADATA_KEY, {})
    return StoredStage(
        bodies=[_body(stage, bodies[one], path) for one in chosen],
        fps=float(stage.GetTimeCodesPerSecond()),
        ground=_ground(stage.GetPrimAtPath(conventions.GROUND)),
        metadata={str(k): v for k, v in dict(data).items() if isinstance(v, str | int | float)},
    )


def extract_names(path: str) -> tuple[str, ...]:
    """Names of the bodies of a stage, in the order they were written.

    Raises:
        InputError: it holds none.
    """
    # a prim ends with its stage
    stage = open_stage(path)
    return tuple(_bodies(stage, path))


def open_stage(path: str | Path) -> Any:
    """The stage as it is on disk now, whatever an earlier read of the same name has cached."""
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path)) if Path(path).is_file() else None
    except Tf.ErrorException:
        layer = None
    if layer is None:
        raise InputError(f"{str(path)!r} is not a USD file that can be read")
    return Usd.Stage.Open(layer)


def body_prims(stage: Any) -> list[Any]:
    """The prims of the world that have a skin and tets, in the order they were written."""
    world = stage.GetPrimAtPath(conventions.WORLD)
    children = world.GetChildren() if world else []
    needed = (conventions.SKIN, conventions.TETS)
    return [prim for prim in children if all(prim.GetChild(name) for name in needed)]


def _bodies(stage: Any, path: str) -> dict[str, Any]:
    bodies = {prim.GetName(): prim for prim in body_prims(stage)}
    if not bodies:
        raise InputError(f"{path!r} holds no character with a skin and tets")
    return bodies


def _body(stage: Any, body: Any, path: str) -> StoredBody:
    skin, tets = (body.GetChild(name) for name in (conventions.SKIN, conventions.TETS))
    codes = tets.GetAttribute("points").GetTimeSamples()
    if not codes:
        raise InputError(f"{path!r} holds no frame")
    fibers = body.GetChild(conventions.FIBERS)
    return StoredBody(
        name=body.GetName(),
        codes=np.array(codes),
        color=stored_value(skin, "primvars:displayColor"),
        rest=stored_value(tets, conventions.REST),
        tets=stored_value(tets, "tetVertexIndices"),
        tet_points=_series(tets, "points", codes),
        velocities=_series(tets, _velocity_name(tets), codes),
        skin_rest=stored_value(skin, "points"),
        skin_points=_series(skin, "points", codes),
        skin_faces=stored_value(skin, "faceVertexIndices"),
        look=stored_look(stage, skin, path),
        fiber_points=_series(fibers, "points", codes) if fibers else None,
        activations=_series(fibers, conventions.ACTIVATION, codes) if fibers else None,
        contacts=_contacts(body.GetChild(conventions.CONTACTS), codes),
        patches=_contacts(body.GetChild(conventions.PATCHES), codes),
    )


def _series(prim: Any, name: str, codes: list[float]) -> Array:
    arrays = [stored_value(prim, name, code) for code in codes]
    for code, array in zip(codes, arrays, strict=True):
        if array.shape != arrays[0].shape:
            raise InputError(
                f"{prim.GetPath()} has {len(array)} of {name!r} at the time code {code:g}, "
                f"and {len(arrays[0])} before"
            )
    return np.stack(arrays)


def _velocity_name(tets: Any) -> str:
    """Where velocities are: stages of older versions have them as USD's own."""
    return conventions.VELOCITY if tets.HasAttribute(conventions.VELOCITY) else "velocities"


def _contacts(prim: Any, codes: list[float]) -> StoredContacts | None:
    if not prim:
        return None
    rows = [_contact_values(prim, code) for code in codes]
    told = {name: path for name, path in PARTNER_PRIMVARS.items() if prim.HasAttribute(path)}
    return StoredContacts(
        points=[row["points"] for row in rows],
        modes=[row[conventions.CONTACT_MODE] for row in rows],
        forces=[row[conventions.CONTACT_FORCE] for row in rows],
        partners=[{name: row[path] for name, path in told.items()} for row in rows],
    )


def _contact_values(prim: Any, code: float) -> dict[str, Array]:
    """What is told of the contacts of a frame; a point without width stands where there is none."""
    names = ["points", conventions.CONTACT_MODE, conventions.CONTACT_FORCE]
    names += [path for path in PARTNER_PRIMVARS.values() if prim.HasAttribute(path)]
    real = stored_value(prim, "widths", code) != 0.0
    stored = {name: stored_value(prim, name, code) for name in names}
    return {name: rows[real] if len(rows) == len(real) else rows for name, rows in stored.items()}


def _ground(prim: Any) -> dict[str, Array] | None:
    if not prim:
        return None
    found = {name: stored_value(prim, name) for name in GROUND_NUMBERS if prim.HasAttribute(name)}
    return {**found, **{name: stored_value(prim, name) for name in ("points", "faceVertexIndices")}}
