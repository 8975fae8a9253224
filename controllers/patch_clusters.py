"""Patches of characters without named ones: parts of the surface, whichever touch or come nearest.

The surface, or a region of it, is divided once, in the rest shape, into parts of about equal size;
a patch is the touching nodes of a part. So a patch keeps its identity from step to step, and while
its nodes stay the same its point moves as they do. Nodes count by the area of the surface around
them, projected on the ground.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray, cross_rows
from warp_softbody.body.mesh import TetMesh
from warp_softbody.controllers.patches import Group, Patch, patches_of
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.ground import Ground
from warp_softbody.world.view import BodyView

IntArray = npt.NDArray[np.int32]
Labels = npt.NDArray[np.intp]

PARTS_A_PATCH = 8
"""Parts of a whole surface for each patch: about an eighth of a round body touches at a time."""

UPRIGHT_SHARE = 0.01
"""Least share of its area with which a node counts, so that a vertical face still has a mean."""

SWEEPS = 100
"""Of k-means, which ends long before."""


class Partition(NamedTuple):
    """Nodes (k,), the part of each (k,), and the middles of the parts at rest (parts, 3)."""

    nodes: IntArray
    labels: Labels
    middles: FloatArray


class _Ground(NamedTuple):
    """What is known of the partition's nodes in this step."""

    gaps: FloatArray
    normals: FloatArray
    areas: FloatArray
    touching: npt.NDArray[np.bool_]


def clustered_patches(
    view: BodyView,
    *,
    count: int = 6,
    region: str | None = None,
    parts: int | None = None,
    last: tuple[Patch, ...] = (),
) -> tuple[Patch, ...]:
    """At most ``count`` patches of the character; none where the scene has no ground.

    Parts that touch come first, then the nearest to the ground, of which the lowest node stands for
    the part. Where more parts touch than there are patches, those stay that were patches before,
    others come by their distance from these, and the rest lend their nodes to the nearest chosen
    one. Patches are ordered by ``Patch.part``.

    Args:
        view: of this step.
        count: patches, 4 to 8.
        region: name of a region of the character; default its whole surface.
        parts: of the partition; default ``count`` for a region, eight times that for a surface.
        last: the patches of the step before.
    """
    checks.instance("view of clustered_patches", view, BodyView)
    last = checks.items("last of clustered_patches", last, Patch)
    count = checks.whole("count of clustered_patches", count)
    if parts is not None:
        parts = checks.whole("parts of clustered_patches", parts, high=2**16)
    if not 4 <= count <= 8:
        raise InputError(f"a character takes 4 to 8 clustered patches, got {count}")
    if parts is not None and parts < count:
        raise InputError(f"clustered patches need at least {count} parts, got {parts}")
    ground = view.scene.ground
    if ground is None:
        return ()
    character = view.scene.character
    nodes = character.mesh.surface_nodes if region is None else character.region(region)
    if not len(nodes):
        raise InputError(f"patch region {region!r} holds no nodes")
    wanted = parts or (count if region is not None else PARTS_A_PATCH * count)
    division = partition(character.mesh, nodes.astype(np.int32).tobytes(), min(wanted, len(nodes)))
    here = _measure(view, ground, division.nodes)
    chosen = _choose(division, here, count, [patch.part for patch in last])
    return _patches(view, ground, division, here, chosen)


@lru_cache(maxsize=8)
def partition(mesh: TetMesh, nodes: bytes, parts: int) -> Partition:
    """Divide surface nodes into parts by k-means on rest positions, weighted by rest area.

    The first middles are the node furthest from the mean of all, then the node furthest from every
    middle so far: nothing is random.
    """
    chosen = np.frombuffer(nodes, np.int32)
    points = mesh.points[chosen]
    weights = _areas(mesh, _crosses(mesh, mesh.points), len(mesh.points))[chosen]
    middles = points[_spread(points, parts)]
    labels = np.full(len(points), -1)
    for _ in range(SWEEPS):
        nearest = _distances(points, middles).argmin(axis=1)
        if np.array_equal(nearest, labels):
            break
        labels = nearest
        for part in np.unique(labels):
            inside = labels == part
            middles[part] = np.average(points[inside], axis=0, weights=weights[inside])
    return Partition(chosen, labels, middles)


def _choose(
    division: Partition, here: _Ground, count: int, last: list[int | None]
) -> npt.NDArray[np.intp]:
    """Ascending parts that become patches.

    Areas do not matter, so that none gives way to another that touches a little more.
    """
    parts = len(division.middles)
    touched = np.unique(division.labels[here.touching])
    if len(touched) > count:
        kept = np.flatnonzero(np.isin(touched, [part for part in last if part is not None]))
        return np.sort(touched[_spread(division.middles[touched], count, kept.tolist()[:count])])
    least = _least_gaps(division, here)
    least[touched] = -np.inf
    return np.sort(np.argsort(least, kind="stable")[: min(count, parts)])


def _least_gaps(division: Partition, here: _Ground) -> FloatArray:
    least = np.full(len(division.middles), np.inf)
    np.minimum.at(least, division.labels, here.gaps)
    return least


def _patches(
    view: BodyView,
    ground: Ground,
    division: Partition,
    here: _Ground,
    chosen: npt.NDArray[np.intp],
) -> tuple[Patch, ...]:
    nodes, labels, middles = division
    least = _least_gaps(division, here)
    owner = _owners(np.unique(labels[here.touching]), chosen, middles)[labels]
    total = float(here.areas[here.touching].sum())
    groups, sizes = [], []
    for part in chosen.tolist():
        mine = (owner == part) & here.touching
        if not mine.any():
            mine = (labels == part) & (here.gaps <= least[part] + 1e-9)
        areas = here.areas[mine]
        sizes.append(float(areas.sum()))
        groups.append(Group(nodes[mine], here.gaps[mine], here.normals[mine], areas / areas.sum()))
    return tuple(
        unchecked_copy(patch, area=size / total if patch.touching else 0.0, part=part)
        for patch, size, part in zip(
            patches_of(view, ground, groups), sizes, chosen.tolist(), strict=True
        )
    )


def _owners(
    touched: npt.NDArray[np.intp], chosen: npt.NDArray[np.intp], middles: FloatArray
) -> npt.NDArray[np.intp]:
    """(parts,): the part whose patch takes a part's nodes, itself where it is chosen."""
    owner = np.arange(len(middles))
    others = sorted(set(touched.tolist()) - set(chosen.tolist()))
    if others:
        owner[others] = chosen[_distances(middles[others], middles[chosen]).argmin(axis=1)]
    return owner


def _measure(view: BodyView, ground: Ground, nodes: IntArray) -> _Ground:
    gaps, normals = ground.measure(view.positions[nodes])
    mesh = view.scene.character.mesh
    crosses = _crosses(mesh, view.positions)
    count = len(view.positions)
    facing = -np.einsum("ij,ij->i", _area_vectors(mesh, crosses, count)[nodes], normals)
    whole = _areas(mesh, crosses, count)[nodes]
    areas = np.maximum(facing, UPRIGHT_SHARE * whole)
    return _Ground(gaps, normals, areas, view.touching[nodes])


def _area_vectors(mesh: TetMesh, crosses: FloatArray, count: int) -> FloatArray:
    """(n, 3) m^2: a third of the outward area vectors of the triangles around each node."""
    return _gathered(mesh, crosses / 6.0, count)


def _areas(mesh: TetMesh, crosses: FloatArray, count: int) -> FloatArray:
    """(n,) m^2: a third of the areas of the triangles around each node."""
    size = np.linalg.norm(crosses, axis=1) / 6.0
    return _gathered(mesh, size[:, None], count)[:, 0]


def _crosses(mesh: TetMesh, positions: FloatArray) -> FloatArray:
    """Twice the outward area vectors of the surface's triangles, (f, 3) m^2."""
    a, b, c = positions[mesh.surface.T]
    return cross_rows(b - a, c - a)


def _gathered(mesh: TetMesh, of_triangles: FloatArray, count: int) -> FloatArray:
    corners = mesh.surface.ravel()
    columns = [np.bincount(corners, np.repeat(column, 3), count) for column in of_triangles.T]
    return np.stack(columns, axis=1)


def _spread(points: FloatArray, count: int, kept: list[int] | None = None) -> list[int]:
    """Indices of ``count`` points far from each other, among them the ones kept."""
    found = list(kept or [])
    if not found:
        found = [int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    away = _distances(points, points[found]).min(axis=1)
    while len(found) < count:
        found.append(int(np.argmax(away)))
        away = np.minimum(away, _distances(points, points[found[-1:]])[:, 0])
    return found


def _distances(points: FloatArray, middles: FloatArray) -> FloatArray:
    squares: FloatArray = ((points[:, None] - middles) ** 2).sum(axis=2)
    return squares
