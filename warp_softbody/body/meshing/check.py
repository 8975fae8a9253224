"""The tet mesh that a mesher returns is compared with the surface that it had to fill."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import IntArray, count_parts, tet_volumes
from warp_softbody.body.meshing.surface import Surface
from warp_softbody.errors import MeshError

ENVELOPE_SLACK = 2.0
"""Room above the envelope that a mesher keeps to, for its own rounding."""


def check_against_surface(
    points: FloatArray, tets: IntArray, surface: Surface, *, mesher: str, envelope: float
) -> None:
    """Compare parts, box and volume of a mesh with the surface it was made from.

    A surface that moves by at most a distance changes the box by at most that distance and the
    volume by about its area times that distance.

    Args:
        points: (n, 3) m, of the mesh that the mesher made.
        tets: (m, 4) of them.
        surface: what it was given.
        mesher: named in the sentence.
        envelope: distance allowed between the two, relative to the diagonal of the surface's box.

    Raises:
        MeshError: what differs, with both values.
    """
    distance = ENVELOPE_SLACK * envelope * surface.diagonal
    if (parts := count_parts(tets)) != 1:
        raise MeshError(
            f"{surface.source}: {mesher} made {parts} separate parts of one surface; "
            f"try a smaller size"
        )
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    apart = float(abs(bounds - surface.bounds).max())
    if apart > distance:
        raise MeshError(
            f"{surface.source}: the box of the mesh by {mesher} lies {apart:.3g} m from the "
            f"surface's, but at most {distance:.3g} m is allowed; try a smaller size"
        )
    volume = float(tet_volumes(points, tets).sum())
    if abs(volume - surface.volume) > surface.area * distance:
        raise MeshError(
            f"{surface.source}: the mesh by {mesher} has a volume of {volume:.6g} m^3, but "
            f"the surface encloses {surface.volume:.6g} m^3; "
            + (surface.crossing or "look for thin walls or cavities, or try a smaller size")
        )
