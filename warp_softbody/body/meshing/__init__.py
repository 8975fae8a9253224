"""A closed surface is filled with tets, and the mesh is compared with the surface."""

from __future__ import annotations

from warp_softbody.body.meshing.surface import Surface, load_surface
from warp_softbody.body.meshing.tetrahedralize import MESHERS, tetrahedralize

__all__ = ["MESHERS", "Surface", "load_surface", "tetrahedralize"]
