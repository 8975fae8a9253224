"""Fill a surface with tets by the mesher of the user's choice, and check the result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warp_softbody import checks
from warp_softbody.errors import InputError
from warp_softbody.mesh import TetMesh
from warp_softbody.meshing import ftetwild_mesher, tetgen_mesher
from warp_softbody.meshing.check import check_against_surface
from warp_softbody.meshing.surface import Surface, load_surface

if TYPE_CHECKING:
    import trimesh

MESHERS = ("ftetwild", "tetgen")

DEFAULT_SIZE = 0.1
"""Target edge length over the diagonal of the box when no size is given."""


def tetrahedralize(
    surface: str | Path | trimesh.Trimesh | Surface,
    *,
    mesher: str = "ftetwild",
    size: float | None = None,
) -> TetMesh:
    """Fill a closed surface with tets.

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
    target = DEFAULT_SIZE * closed.diagonal if size is None else size
    if mesher == "tetgen":
        options = tetgen_mesher.options_for_size(target)
        points, tets = tetgen_mesher.mesh_with_tetgen(
            closed.points, closed.faces, options, source=closed.source
        )
        envelope = tetgen_mesher.ENVELOPE
    else:
        points, tets = ftetwild_mesher.mesh_with_ftetwild(closed, target)
        envelope = ftetwild_mesher.ENVELOPE
    mesh = TetMesh.from_arrays(points, tets, source=closed.source, allow_parts=True)
    check_against_surface(mesh, closed, mesher=mesher, envelope=envelope)
    return mesh
