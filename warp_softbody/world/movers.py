"""A mover is a rigid thing on a path: it pushes what it meets, and is counted in contact."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.handles import Handle
from warp_softbody.world.joined_bodies import Body
from warp_softbody.world.motion_path import MotionPath

if TYPE_CHECKING:
    import trimesh

COLOR = (0.45, 0.47, 0.50)


def mover(
    surface: str | Path | TetMesh | trimesh.Trimesh,
    path: MotionPath,
    *,
    name: str = "mover",
    color: tuple[float, float, float] = COLOR,
) -> tuple[Body, Handle]:
    """Return a rigid body with the surface of a triangle mesh, and the handle that moves all of it.

    ``Scene(others=(body,), handles=(handle,))`` has it; other bodies meet it as any other.

    Args:
        surface: a file (.stl, .obj, .ply, .off), a trimesh surface, both closed, or a tet mesh.
        path: of the body from where the surface stands.
        name: of the body.
        color: linear RGB.

    Raises:
        MeshError: the surface is not closed, or cannot be read.
    """
    checks.instance("path of mover", path, MotionPath)
    named = input_kinds.identifier("name of mover", name)
    if isinstance(surface, TetMesh):
        mesh = surface
    else:
        # its libraries take long to load
        from warp_softbody.body.meshing.star_fill import rigid_mesh

        if not (hasattr(surface, "vertices") and hasattr(surface, "faces")):
            surface = input_kinds.path("surface of mover", surface)
        mesh = rigid_mesh(surface)
    body = Character(name=named, mesh=mesh, color=input_kinds.color("color of mover", color))
    return Body(character=body), Handle(region=named, path=path)
