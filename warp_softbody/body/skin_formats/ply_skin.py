"""A PLY with a texture coordinate a point, and the picture that a comment names."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_softbody.body.mesh_formats.ply import vertex_columns
from warp_softbody.body.mesh_formats.surface_files import read_surface
from warp_softbody.body.skin_formats.contents import NO_TEXTURE, SkinContents
from warp_softbody.body.skin_formats.obj_skin import LARGEST_PICTURE

COORDINATES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


def read_ply_skin(path: Path) -> SkinContents:
    """Points, triangles, and the texture.

    Raises:
        ValueError, OSError: it is none, or cannot be read.
    """
    surface = read_surface(path)
    columns = vertex_columns(path)
    texture, notes = NO_TEXTURE, []
    for names in COORDINATES:
        if all(name in columns for name in names):
            places = np.stack([columns[name] for name in names], axis=1)
            texture = places.astype(np.float64), surface.faces
    material: dict[str, object] = {"name": path.stem}
    picture = _picture(path)
    if picture is not None and picture.is_file():
        if picture.stat().st_size > LARGEST_PICTURE:
            raise ValueError(f"its texture {picture.name!r} is larger than {LARGEST_PICTURE} bytes")
        material["texture"] = picture.read_bytes()
    elif picture is not None:
        notes.append(f"the texture {picture.name!r} cannot be read")
    return SkinContents(
        surface.points,
        surface.faces,
        *texture,
        [material],
        np.zeros(len(surface.faces), dtype=np.int64),
        tuple(notes),
    )


def _picture(path: Path) -> Path | None:
    """The file of ``comment TextureFile name``, as MeshLab writes it."""
    header = path.read_bytes().partition(b"end_header")[0].decode("ascii", errors="replace")
    for line in header.splitlines():
        words = line.split(None, 2)
        if len(words) == 3 and words[:2] == ["comment", "TextureFile"]:
            return path.parent / words[2].strip()
    return None
