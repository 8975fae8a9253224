"""What the motions measure on a body: means of its regions, and by how much it has turned."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray, cross_rows
from warp_softbody.body import mesh_geometry
from warp_softbody.body.mesh import TetMesh
from warp_softbody.controllers.contact_quadrature import measure, shares_of
from warp_softbody.world.ground import Plane
from warp_softbody.world.view import BodyView

IntArray = npt.NDArray[np.int32]

BASE_PATCHES = ("base_patch_0", "base_patch_1", "base_patch_2", "base_patch_3")
"""The quadrants of a letter's underside."""


def region_mean(view: BodyView, values: FloatArray, region: str) -> FloatArray:
    """The mean (3,) of nodal values (n, 3) over a named region of the character at rest."""
    nodes, shares = view.kept(("mean", region), lambda: _region_shares(view, region))
    return np.asarray(shares @ values[nodes])


def _region_shares(view: BodyView, region: str) -> tuple[IntArray, FloatArray]:
    """Nodes of a region and how much each counts, sum one."""
    character = view.scene.character
    nodes = character.region(region)
    sizes = _sizes(character.mesh, (nodes.tobytes(),))[0]
    return nodes, sizes / sizes.sum()


def contact_point(view: BodyView, region: str) -> FloatArray:
    """Where (3,) m a region of the character's surface touches, or comes nearest to, the ground."""
    nodes = view.scene.character.region(region)
    near = measure(view, view.scene.ground or Plane(), [nodes])
    return np.asarray(shares_of(view, near).nodes @ view.positions[nodes])


def mean_weights(view: BodyView, regions: tuple[str, ...]) -> FloatArray:
    """Nodal weights (n,) of the mean over some regions at rest; their sum is one."""
    weights: FloatArray = view.kept(("mean weights", regions), lambda: _made(view, regions))
    return weights


def _made(view: BodyView, regions: tuple[str, ...]) -> FloatArray:
    character = view.scene.character
    nodes = tuple(character.region(name).tobytes() for name in regions)
    return _mean_weights(character.mesh, nodes, view.node_count)


@lru_cache(maxsize=64)
def _mean_weights(mesh: TetMesh, regions: tuple[bytes, ...], count: int) -> FloatArray:
    """Of regions given by their nodes, int32; kept, as every step asks for it, and read-only."""
    weights = np.zeros(count)
    for own, sizes in zip(regions, _sizes(mesh, regions), strict=True):
        weights[np.frombuffer(own, np.int32)] += sizes
    weights /= weights.sum()
    weights.setflags(write=False)
    return weights


@lru_cache(maxsize=64)
def _sizes(mesh: TetMesh, regions: tuple[bytes, ...]) -> list[FloatArray]:
    """How much of each region (k,) is around its nodes, at rest: a quadrature, on every mesh alike.

    By the volumes (m^3) of the tets within the regions, where each has some; else by the areas
    (m^2) of the surface's triangles within them, where each has some; else all nodes count alike.
    """
    nodes = [np.frombuffer(region, np.int32) for region in regions]
    volumes = mesh_geometry.tet_volumes(mesh.points, mesh.tets)
    a, b, c = mesh.points[mesh.surface.T]
    areas = np.linalg.norm(cross_rows(b - a, c - a), axis=1) / 2.0
    for cells, extents in ((mesh.tets, volumes), (mesh.surface, areas)):
        found = [_shared_out(cells, extents, own, len(mesh.points)) for own in nodes]
        if all(sizes.any() for sizes in found):
            return found
    return [np.ones(len(own)) for own in nodes]


def _shared_out(cells: IntArray, extents: FloatArray, nodes: IntArray, count: int) -> FloatArray:
    """Extents (c,) of the cells (c, corners) within a set of nodes, (k,): to each corner alike."""
    inside = np.isin(cells, nodes).all(axis=1)
    corners = cells.shape[1]
    share = np.repeat(extents[inside] / corners, corners)
    return np.asarray(np.bincount(cells[inside].ravel(), share, count)[nodes])


def angle_turned(view: BodyView, first: int, second: int) -> float:
    """Angle (rad) from axis ``first`` towards axis ``second`` by which the body has turned.

    It is that of the rotation in the plane of these two axes (0, 1 or 2) that brings the rest shape
    nearest to the present one, nodes weighted by their masses.
    """
    rest = view.scene.character.mesh.points
    masses, positions = view.masses[: len(rest)], view.positions[: len(rest)]
    arms = (rest - masses @ rest / view.mass) * masses[:, None]
    moments = arms.T @ (positions - view.center_of_mass)
    turned = moments[first, second] - moments[second, first]
    return float(np.arctan2(turned, moments[first, first] + moments[second, second]))


def moments_of_inertia(view: BodyView) -> FloatArray:
    """(3,) kg m^2: moments of inertia about the axes through the centre of mass."""
    squares = (view.positions - view.center_of_mass) ** 2
    return np.asarray(view.masses @ (squares.sum(axis=1, keepdims=True) - squares))
