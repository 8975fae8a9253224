"""From a stranger's surface, or tet mesh, to all that a character is made of."""

from __future__ import annotations

import re
import warnings
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body import other_surfaces
from warp_softbody.body.making.filling import fill
from warp_softbody.body.making.given_surface import given_surface
from warp_softbody.body.making.limbs import find_limbs
from warp_softbody.body.making.made import Made, made_of_mesh
from warp_softbody.body.making.placing import floor_place, to_metres
from warp_softbody.body.making.soles import broad_soles, flat_soles
from warp_softbody.body.making.solid import solid_of
from warp_softbody.body.making.surface_skin import surface_skin
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_files import FORMATS
from warp_softbody.body.skin import Skin
from warp_softbody.errors import InputError, MeshError, MeshWarning
from warp_softbody.inputs import checks, input_kinds

if TYPE_CHECKING:
    import trimesh

TETS, LEAST_TETS, MOST_TETS = 1500, 100, 200_000
"""Tets that a character gets where none are asked for, and that may be asked for."""

CLOSE = 0.2
"""Share by which the tets made may differ from those asked for without a word."""

WATER = 1000.0
"""Density of a body that is told no other, kg/m^3."""


def made_from_surface(
    surface: str | Path | TetMesh | Skin | trimesh.Trimesh,
    *,
    name: str | None = None,
    unit: str | float | None = None,
    height: float | None = None,
    up: str | None = None,
    forward: str | None = None,
    repair: str = "auto",
    tets: int | None = None,
    density: float = WATER,
    stand: bool = True,
) -> Made:
    """All that a character is made of; ``stand`` is the on_floor of `Character.from_surface`."""
    checks.choice("repair of a surface", repair, ("auto", "none"))
    if tets is not None:
        tets = checks.whole("tets of a character", tets, low=LEAST_TETS, high=MOST_TETS)
    density = checks.number("density of a character", density, above=0.0, unit="kg/m^3")
    checks.truth("on_floor of a character", stand)
    if name is not None:
        input_kinds.identifier("name of a character", name)
    place = partial(to_metres, unit=unit, height=height, forward=forward)
    if (mesh := _tet_mesh(surface)) is not None:
        if tets is not None:
            raise InputError("tets of a character are for surfaces; a tet mesh is kept as it is")
        source = "mesh" if surface is mesh else str(surface)
        points = (
            mesh.points
            @ place(mesh.points, up="z" if up is None else up, declared=None, source=source).T
        )
        if stand:
            points = points - floor_place(points)
        placed = TetMesh(points, mesh.tets, regions=mesh.regions)
        return made_of_mesh(placed, name or _identifier(source), density)
    if isinstance(surface, str | Path):
        reader = other_surfaces.READERS.get(Path(surface).suffix.lower())
        if reader is not None:
            # read once, with its texture
            name = name or _identifier(str(surface))
            surface = reader(Path(surface))
    given = given_surface(surface)
    if up is None:
        up = given.up or "z"
    matrix = place(given.points, up=up, declared=given.unit, source=given.source)
    solid = solid_of(given.points @ matrix.T, given.faces, given.source)
    if repair == "none" and solid.repairs:
        raise MeshError(
            f"{given.source}: the surface is flawed, and repair is 'none': 'auto' would have "
            f"{', '.join(solid.repairs)}"
        )
    filled = fill(solid, tets or TETS)
    origin = floor_place(filled.points) if stand else np.zeros(3)
    points = filled.points - origin
    missed = None if filled.missed is None else filled.missed - origin
    _tell(solid.repairs, len(filled.tets), tets or TETS, missed, given.source)
    if stand:
        points = flat_soles(points, filled.tets)
    skin = surface_skin(surface, solid, matrix, origin)
    mesh = TetMesh(points, filled.tets, skin=skin)
    # before feet get soles, whose corners look like limbs
    limbs = find_limbs(mesh)
    if stand:
        broad = broad_soles(points, filled.tets)
        mesh = TetMesh(broad.points, broad.tets, skin=skin)
        limbs = tuple(limb.renumbered(broad.nodes) for limb in limbs)
    name = name or _identifier(given.source)
    return made_of_mesh(mesh, name, density, solid.repairs, limbs)


def _tet_mesh(surface: object) -> TetMesh | None:
    """The tet mesh that was given, or that a file holds; None for a surface."""
    if isinstance(surface, TetMesh):
        return surface
    if isinstance(surface, str | Path) and Path(surface).suffix.lower() in FORMATS:
        return TetMesh.read(surface)
    return None


def _tell(
    repairs: tuple[str, ...], made: int, wanted: int, missed: FloatArray | None, source: str
) -> None:
    """Warn, on behalf of the caller of `Character.from_surface`."""
    notes = [*repairs]
    if abs(made - wanted) > CLOSE * wanted:
        notes.append(f"{made} tets made where {wanted} were asked for, to hold its thinnest limbs")
    if missed is not None:
        x, y, z = missed
        notes.append(
            f"a part near ({x:.3g}, {y:.3g}, {z:.3g}) m is too thin for tets of this size and "
            "carried along by its skin"
        )
    if notes:
        warnings.warn(f"{source}: {', '.join(notes)}", MeshWarning, stacklevel=4)


def _identifier(source: str) -> str:
    """The file's name as the name of a prim."""
    stem = re.sub(r"\W+", "_", Path(source).stem, flags=re.ASCII).strip("_") or "body"
    return stem if not stem[0].isdigit() else f"body_{stem}"
