"""A body's prims are defined at rest: skin, tets, fibres, contacts and patches."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdShade

from warp_softbody.arrays import FloatArray
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.creases import rim
from warp_softbody.stage_exports.palette import activation_palette, activation_steps, mode_palette
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.skin_looks import define_look
from warp_softbody.world.frame import GROUND

# Drawn widths, as parts of the diagonal of the body's box.
_FIBER_WIDTH = 0.014
_CONTACT_WIDTH = 0.018


def define_body(stage: Any, body: StagedBody, material: Any, textures: str) -> None:
    """Author a body's prim with what it has; no muscles, no fibres.

    An own skin has its own materials, with textures in the folder of that name beside the stage.
    Fibres and contacts have no material, so that viewers draw them in their own colours, which
    change: few read those through a material.
    """
    path = conventions.character_path(body.character.name)
    model = UsdGeom.Xform.Define(stage, path)
    model = Usd.ModelAPI(model)
    model.SetKind(Kind.Tokens.component)
    model.SetAssetName(body.character.name)
    skin = _define_skin(stage, f"{path}/{conventions.SKIN}", body)
    if body.character.skin is None:
        UsdShade.MaterialBindingAPI.Apply(skin.GetPrim()).Bind(material)
    else:
        define_look(stage, body, skin, body.character.skin, textures)
    _define_tets(stage, f"{path}/{conventions.TETS}", body)
    if body.character.segment_count:
        _define_fibers(stage, f"{path}/{conventions.FIBERS}", body)
    if body.touches:
        contacts = _define_contacts(stage, f"{path}/{conventions.CONTACTS}", body)
        _define_partners(contacts)
    if body.plans:
        patches = _define_contacts(stage, f"{path}/{conventions.PATCHES}", body)
        patches.CreatePurposeAttr(UsdGeom.Tokens.guide)


def fiber_width(body: StagedBody) -> float:
    """Width of a drawn fibre, m."""
    return _FIBER_WIDTH * body.size


def contact_width(body: StagedBody) -> float:
    """Width of a drawn contact, m."""
    return _CONTACT_WIDTH * body.size


def _define_skin(stage: Any, path: str, body: StagedBody) -> Any:
    layout = body.layout
    skin = UsdGeom.Mesh.Define(stage, path)
    points = values.vectors(layout.skin_at(np.asarray(body.character.mesh.points)))
    skin.CreatePointsAttr(points)
    skin.CreateExtentAttr(values.extent(points))
    skin.CreateFaceVertexCountsAttr(values.integers(np.full(len(layout.skin_faces), 3)))
    skin.CreateFaceVertexIndicesAttr(values.integers(layout.skin_faces))
    # Programs find the normals of such a mesh themselves, which follow its motion and take no room.
    # Where one draws it subdivided, both sides of a crease keep its points.
    skin.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.loop)
    corners = rim(layout.skin_faces)
    skin.CreateCornerIndicesAttr(values.integers(corners))
    sharp = np.full(len(corners), UsdGeom.Mesh.SHARPNESS_INFINITE)
    skin.CreateCornerSharpnessesAttr(values.floats(sharp))
    skin.CreateDisplayColorAttr([Gf.Vec3f(*body.character.color)])
    return skin


def _define_tets(stage: Any, path: str, body: StagedBody) -> Any:
    mesh = body.character.mesh
    tets = UsdGeom.TetMesh.Define(stage, path)
    points = values.vectors(mesh.points)
    tets.CreatePointsAttr(points)
    tets.CreateExtentAttr(values.extent(points))
    tets.CreateTetVertexIndicesAttr(values.quadruples(mesh.tets))
    tets.CreateSurfaceFaceVertexIndicesAttr(values.triples(mesh.surface))
    tets.CreatePurposeAttr(UsdGeom.Tokens.guide)
    _primvar(tets, conventions.REST, Sdf.ValueTypeNames.Point3fArray, "vertex").Set(points)
    _primvar(tets, conventions.VELOCITY, Sdf.ValueTypeNames.Vector3fArray, "vertex").Set(
        values.vectors(np.zeros(mesh.points.shape))
    )
    return tets


def _define_fibers(stage: Any, path: str, body: StagedBody) -> Any:
    """One two-point curve a segment, so that a uniform primvar is one value a segment."""
    layout = body.layout
    fibers = UsdGeom.BasisCurves.Define(stage, path)
    points = values.vectors(layout.fiber_vertices[layout.segment_ends.reshape(-1)])
    width = fiber_width(body)
    slack = np.ones(len(layout.segment_ends))
    fibers.CreateTypeAttr(UsdGeom.Tokens.linear)
    fibers.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
    fibers.CreateCurveVertexCountsAttr(values.integers(np.full(len(slack), 2)))
    fibers.CreatePointsAttr(points)
    fibers.CreateExtentAttr(values.extent(points, width))
    fibers.CreateWidthsAttr(values.floats([width]))
    fibers.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    activation = Sdf.ValueTypeNames.FloatArray
    _primvar(fibers, conventions.ACTIVATION, activation, "uniform").Set(values.floats(slack))
    _color(fibers, UsdGeom.Tokens.uniform, activation_palette(), activation_steps(slack))
    return fibers


def _define_contacts(stage: Any, path: str, body: StagedBody) -> Any:
    """No contact at rest, which is one point without width: few viewers bear a set without any.

    Frames bring a width a point: USD computes no extent from one for all.
    """
    contacts = UsdGeom.Points.Define(stage, path)
    point = values.vectors(np.asarray(body.character.mesh.points).mean(axis=0, keepdims=True))
    zero = values.vectors(np.zeros((1, 3)))
    contacts.CreatePointsAttr(point)
    contacts.CreateExtentAttr(values.extent(point))
    contacts.CreateWidthsAttr(values.floats([0.0]))
    contacts.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
    _color(contacts, UsdGeom.Tokens.vertex, mode_palette(), [0])
    mode = Sdf.ValueTypeNames.IntArray
    _primvar(contacts, conventions.CONTACT_MODE, mode, "vertex").Set(values.integers([0]))
    force = Sdf.ValueTypeNames.Vector3fArray
    _primvar(contacts, conventions.CONTACT_FORCE, force, "vertex").Set(zero)
    return contacts


def _define_partners(contacts: Any) -> None:
    for name, kind, none in (
        (conventions.CONTACT_NODE, Sdf.ValueTypeNames.IntArray, values.integers([-1])),
        (conventions.CONTACT_PARTNER, Sdf.ValueTypeNames.IntArray, values.integers([GROUND])),
        (
            conventions.CONTACT_PARTNER_NODES,
            Sdf.ValueTypeNames.Int3Array,
            values.triples([[-1, -1, -1]]),
        ),
        (
            conventions.CONTACT_PARTNER_WEIGHTS,
            Sdf.ValueTypeNames.Float3Array,
            values.vectors(np.zeros((1, 3))),
        ),
    ):
        _primvar(contacts, name, kind, "vertex").Set(none)


def _color(prim: Any, interpolation: str, palette: FloatArray, places: npt.ArrayLike) -> None:
    """A colour a curve or point, as its place in a palette."""
    color = prim.CreateDisplayColorPrimvar(interpolation)
    color.Set(values.vectors(palette))
    color.SetIndices(values.integers(places))


def _primvar(prim: Any, name: str, type_name: Any, interpolation: str) -> Any:
    short = name.removeprefix("primvars:")
    made = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(short, type_name, interpolation)
    made.GetAttr().SetDocumentation(conventions.MEANINGS[name])
    return made
