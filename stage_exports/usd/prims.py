"""A body's prims are defined at rest: skin, tets, fibres, contacts and patches."""

from __future__ import annotations

from typing import Any

import numpy as np
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdShade

from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.palette import activation_colors
from warp_softbody.stage_exports.usd import usd_arrays as values

# Drawn widths, as parts of the diagonal of the body's box.
_FIBER_WIDTH = 0.010
_CONTACT_WIDTH = 0.018


def define_body(stage: Any, body: StagedBody, material: Any) -> None:
    """Author a body's prim with what it has; no muscles, no fibres."""
    path = conventions.character_path(body.character.name)
    model = UsdGeom.Xform.Define(stage, path)
    Usd.ModelAPI(model).SetKind(Kind.Tokens.component)
    skin = _define_skin(stage, f"{path}/{conventions.SKIN}", body)
    shown = [skin]
    _define_tets(stage, f"{path}/{conventions.TETS}", body)
    if body.character.segment_count:
        shown.append(_define_fibers(stage, f"{path}/{conventions.FIBERS}", body))
    if body.touches:
        shown.append(_define_contacts(stage, f"{path}/{conventions.CONTACTS}"))
        _define_partners(shown[-1])
    if body.plans:
        patches = _define_contacts(stage, f"{path}/{conventions.PATCHES}")
        patches.CreatePurposeAttr(UsdGeom.Tokens.guide)
        shown.append(patches)
    for prim in shown:
        UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def fiber_width(body: StagedBody) -> float:
    """Width of a drawn fibre, m."""
    return _FIBER_WIDTH * body.size


def contact_width(body: StagedBody) -> float:
    """Width of a drawn contact, m."""
    return _CONTACT_WIDTH * body.size


def _define_skin(stage: Any, path: str, body: StagedBody) -> Any:
    layout = body.layout
    skin = UsdGeom.Mesh.Define(stage, path)
    points = values.vectors(body.character.mesh.points[layout.skin_nodes])
    skin.CreatePointsAttr(points)
    skin.CreateExtentAttr(values.extent(points))
    skin.CreateFaceVertexCountsAttr(values.integers(np.full(len(layout.skin_faces), 3)))
    skin.CreateFaceVertexIndicesAttr(values.integers(layout.skin_faces))
    skin.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
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
    fibers.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform).Set(
        values.vectors(activation_colors(slack))
    )
    return fibers


def _define_contacts(stage: Any, path: str) -> Any:
    """No contact at rest. Frames bring a width a point: USD computes no extent from one for all."""
    contacts = UsdGeom.Points.Define(stage, path)
    empty = values.vectors(np.zeros((0, 3)))
    contacts.CreatePointsAttr(empty)
    contacts.CreateExtentAttr(values.extent(empty))
    contacts.CreateWidthsAttr(values.floats([]))
    contacts.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex).Set(empty)
    mode = Sdf.ValueTypeNames.IntArray
    _primvar(contacts, conventions.CONTACT_MODE, mode, "vertex").Set(values.integers([]))
    force = Sdf.ValueTypeNames.Vector3fArray
    _primvar(contacts, conventions.CONTACT_FORCE, force, "vertex").Set(empty)
    return contacts


def _define_partners(contacts: Any) -> None:
    for name, kind, empty in (
        (conventions.CONTACT_NODE, Sdf.ValueTypeNames.IntArray, values.integers([])),
        (conventions.CONTACT_PARTNER, Sdf.ValueTypeNames.IntArray, values.integers([])),
        (conventions.CONTACT_PARTNER_NODES, Sdf.ValueTypeNames.Int3Array, values.triples([])),
        (
            conventions.CONTACT_PARTNER_WEIGHTS,
            Sdf.ValueTypeNames.Float3Array,
            values.vectors(np.zeros((0, 3))),
        ),
    ):
        _primvar(contacts, name, kind, "vertex").Set(empty)


def _primvar(prim: Any, name: str, type_name: Any, interpolation: str) -> Any:
    short = name.removeprefix("primvars:")
    return UsdGeom.PrimvarsAPI(prim).CreatePrimvar(short, type_name, interpolation)
