"""A take read back from its file, so that motions are measured on what was exported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Sdf, Tf, Usd

from warp_softbody.errors import InputError
from warp_softbody.frame import ContactSample
from warp_softbody.ground import Ground
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.conventions import FloatArray, IntArray
from warp_softbody.stage_exports.grounds import read_ground


@dataclass(frozen=True, kw_only=True)
class Take:
    """One body's motion in NumPy; lengths as stored, in single precision, widened to float64.

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
    """Read one body of a file that StageWriter wrote; any other is refused in one sentence.

    Args:
        path: the stage.
        name: of the body; None for the first, the scene's character.
    """
    stage = open_stage(path)
    bodies = {body.GetName(): body for body in _bodies(stage, path)}
    if name is None:
        return _take(stage, next(iter(bodies.values())), path)
    if name not in bodies:
        raise InputError(f"{str(path)!r} holds no body {name!r}; it holds: {', '.join(bodies)}")
    return _take(stage, bodies[name], path)


def read_takes(path: str | Path) -> tuple[Take, ...]:
    """All bodies of a stage, in the order of `body_names`."""
    stage = open_stage(path)
    return tuple(_take(stage, body, path) for body in _bodies(stage, path))


def body_names(path: str | Path) -> tuple[str, ...]:
    """Names of the bodies of a stage, the scene's character first."""
    # a prim ends with its stage
    stage = open_stage(path)
    return tuple(body.GetName() for body in _bodies(stage, path))


def _take(stage: Any, body: Any, path: str | Path) -> Take:
    skin, tets = (body.GetChild(name) for name in (conventions.SKIN, conventions.TETS))
    codes = tets.GetAttribute("points").GetTimeSamples()
    if not codes:
        raise InputError(f"{str(path)!r} holds no frame")
    rate = stage.GetTimeCodesPerSecond()
    fiber_points, activations = _fibers(body.GetChild(conventions.FIBERS), codes)
    return Take(
        name=body.GetName(),
        color=_triple(_value(skin, "primvars:displayColor")[0]),
        fps=rate,
        times=np.array(codes) / rate,
        rest=_floats(_value(tets, conventions.REST)),
        tets=_integers(_value(tets, "tetVertexIndices")).reshape(-1, 4),
        tet_points=_series(tets, "points", codes),
        velocities=_series(tets, "velocities", codes),
        skin_rest=_floats(_value(skin, "points")),
        skin_points=_series(skin, "points", codes),
        skin_faces=_integers(_value(skin, "faceVertexIndices")).reshape(-1, 3),
        fiber_points=fiber_points,
        activations=activations,
        contacts=_contacts(body.GetChild(conventions.CONTACTS), codes),
        patches=_contacts(body.GetChild(conventions.PATCHES), codes),
        ground=read_ground(stage.GetPrimAtPath(conventions.GROUND)),
        metadata=stage.GetRootLayer().customLayerData.get(conventions.METADATA_KEY, {}),
    )


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


def _bodies(stage: Any, path: str | Path) -> list[Any]:
    bodies = body_prims(stage)
    if not bodies:
        raise InputError(f"{str(path)!r} holds no character with a skin and tets")
    return bodies


def _value(prim: Any, name: str, code: float | None = None) -> Any:
    attribute = prim.GetAttribute(name)
    value = attribute.Get() if code is None else attribute.Get(code)
    if value is None:
        raise InputError(f"{prim.GetPath()} has no value of {name!r}")
    return value


def _series(prim: Any, name: str, codes: list[float]) -> FloatArray:
    return np.stack([_floats(_value(prim, name, code)) for code in codes])


def _fibers(prim: Any, codes: list[float]) -> tuple[FloatArray, FloatArray]:
    if not prim:
        return np.zeros((len(codes), 0, 2, 3)), np.zeros((len(codes), 0))
    points = _series(prim, "points", codes)
    activations = _series(prim, conventions.ACTIVATION, codes)
    return points.reshape(len(codes), -1, 2, 3), activations


def _contacts(prim: Any, codes: list[float]) -> tuple[ContactSample, ...]:
    if not prim:
        return tuple(ContactSample() for _ in codes)
    return tuple(
        ContactSample(
            points=_floats(_value(prim, "points", code)).reshape(-1, 3),
            modes=_integers(_value(prim, conventions.CONTACT_MODE, code)),
            forces=_floats(_value(prim, conventions.CONTACT_FORCE, code)).reshape(-1, 3),
            **_partners(prim, code),
        )
        for code in codes
    )


def _partners(prim: Any, code: float) -> dict[str, Any]:
    """Nodes and other sides of contacts, where a stage tells them."""
    if not prim.HasAttribute(conventions.CONTACT_PARTNER):
        return {}
    corners = _value(prim, conventions.CONTACT_PARTNER_NODES, code)
    weights = _value(prim, conventions.CONTACT_PARTNER_WEIGHTS, code)
    return {
        "nodes": _integers(_value(prim, conventions.CONTACT_NODE, code)),
        "partners": _integers(_value(prim, conventions.CONTACT_PARTNER, code)),
        "partner_nodes": _integers(corners).reshape(-1, 3),
        "partner_weights": _floats(weights).reshape(-1, 3),
    }


def _triple(value: npt.ArrayLike) -> tuple[float, float, float]:
    x, y, z = np.asarray(value, dtype=np.float64).tolist()
    return x, y, z


def _floats(value: npt.ArrayLike) -> FloatArray:
    return np.asarray(value, dtype=np.float64)


def _integers(value: npt.ArrayLike) -> IntArray:
    return np.array(value, dtype=np.int32)
