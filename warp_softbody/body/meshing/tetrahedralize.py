"""A surface is filled with tets by the mesher of the user's choice, and the result is checked."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warp_softbody.body.mesh_checks import CleanArrays, clean_arrays
from warp_softbody.body.meshing import ftetwild_mesher, tetgen_mesher
from warp_softbody.body.meshing.check import check_against_surface
from warp_softbody.body.meshing.ftetwild_mesher import TETS_PER_CUBE
from warp_softbody.body.meshing.surface import Surface, load_surface
from warp_softbody.errors import InputError, MeshError
from warp_softbody.inputs import checks

if TYPE_CHECKING:
    import trimesh

MESHERS = ("ftetwild", "tetgen")

DEFAULT_SIZE = 0.1
"""Target edge length over the diagonal of the box when no size is given."""


MOST_TETS = 1e7
"""Tets that a size may ask for; more would take a day and all memory."""


def tetrahedralize(
    surface: str | Path | trimesh.Trimesh | Surface,
    *,
    mesher: str = "ftetwild",
    size: float | None = None,
) -> CleanArrays:
    """Fill a closed surface with tets; `TetMesh.from_surface` makes a mesh of them.

    Args:
        surface: a file, a trimesh surface, or what `load_surface` made of one.
        mesher: "ftetwild" or "tetgen".
        size: target edge length, m; None for a tenth of the diagonal of the surface's box.

    Raises:
        InputError: unknown mesher, or a size that is not finite and positive.
        MissingExtraError: the mesher is not installed.
        MeshError: unusable surface, failed meshing, or a mesh that is not the surface's.
    """
    if not isinstance(mesher, str) or mesher not in MESHERS:
        raise InputError(
            f"there is no mesher {checks.shown(mesher)}; there are: {', '.join(MESHERS)}"
        )
    if size is not None:
        size = checks.number("the mesh size", size, above=0.0, unit="m")
    closed = surface if isinstance(surface, Surface) else load_surface(surface)
    target = _target(closed, size)
    if mesher == "tetgen" and closed.crossing:
        raise MeshError(
            f"{closed.source}: {closed.crossing}, which tetgen does not take; "
            f"mend the surface or use the mesher 'ftetwild'"
        )
    if mesher == "tetgen":
        options = tetgen_mesher.options_for_size(target)
        points, tets = tetgen_mesher.mesh_with_tetgen(
            closed.points, closed.faces, options, source=closed.source
        )
        envelope = tetgen_mesher.ENVELOPE
    else:
        points, tets = ftetwild_mesher.mesh_with_ftetwild(closed, target)
        envelope = ftetwild_mesher.ENVELOPE
    clean = clean_arrays(points, tets, source=closed.source, allow_parts=True)
    check_against_surface(clean.points, clean.tets, closed, mesher=mesher, envelope=envelope)
    return clean


def _target(surface: Surface, size: float | None) -> float:
    """Edge length aimed at, m; no longer than the surface's box.

    Raises:
        InputError: the size asks for more than `MOST_TETS`.
    """
    if size is None:
        return DEFAULT_SIZE * surface.diagonal
    filled = surface.volume / surface.diagonal**3
    fineness = max(1.0, min(surface.diagonal / size, 1e9))
    if (tets := TETS_PER_CUBE * filled * fineness**3) > MOST_TETS:
        raise InputError(
            f"{surface.source}: a mesh size of {size:g} m asks for some {tets:.1g} tets, but at "
            f"most {MOST_TETS:g} are made"
        )
    return min(float(size), surface.diagonal)
