"""The surface that a character was made from is what is seen of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.given_surface import GLB, GLB_AXES
from warp_softbody.body.making.solid import Solid
from warp_softbody.body.skin import READERS, Skin

MOST_TRIANGLES = 20_000
"""Of a surface without texture: a larger one costs every frame of a stage more than it shows."""


def surface_skin(
    surface: object, solid: Solid, matrix: FloatArray, origin: FloatArray
) -> Skin | None:
    """The skin of a character made of a surface; None where its tets' own surface is seen.

    Args:
        surface: file or object that was given; files with a texture keep it.
        solid: its triangles, in m.
        matrix: (3, 3), from the file's points to m.
        origin: (3,) m, the place that has come to the origin.
    """
    if isinstance(surface, Skin) and surface.textured:
        return replace(surface, points=surface.points @ matrix.T - origin)
    if isinstance(surface, str | Path) and Path(surface).suffix.lower() in READERS:
        skin = Skin.read(surface)
        if skin.textured:
            glb = Path(surface).suffix.lower() == GLB
            points = skin.points @ GLB_AXES if glb else skin.points
            return replace(skin, points=points @ matrix.T - origin)
    if len(solid.faces) > MOST_TRIANGLES:
        return None
    return Skin(points=solid.points - origin, faces=solid.faces.astype(np.int32))
