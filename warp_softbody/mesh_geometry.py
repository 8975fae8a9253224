"""The old place of `warp_softbody.body.mesh_geometry`, kept for scripts that name it."""

from warp_softbody.body.mesh_geometry import shortest_edge, surface_triangles, tet_volumes

__all__ = ["shortest_edge", "surface_triangles", "tet_volumes"]
