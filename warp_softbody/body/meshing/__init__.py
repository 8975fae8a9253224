"""From a closed surface to a tet mesh that is compared with it."""

from __future__ import annotations

from warp_softbody.body.meshing.surface import Surface, load_surface
from warp_softbody.body.meshing.tetrahedralize import MESHERS, tetrahedralize

__all__ = ["MESHERS", "Surface", "load_surface", "tetrahedralize"]
