"""Patches of characters without named ones: parts of the surface, whichever touch or come nearest.

The surface, or a region of it, is divided once, in the rest shape, into parts of about equal size;
a patch is what of a part is near the ground. So a patch keeps its identity from step to step, and
nodes count in it as in that of a named region (`contact_quadrature`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.controllers.contact_quadrature import TINY, NearSurface, measure, rest_areas
from warp_softbody.controllers.patches import Patch, patches_of
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView

IntArray = npt.NDArray[np.int32]
Labels = npt.NDArray[np.intp]

PARTS_A_PATCH = 8
"""Parts of a whole surface for each patch: about an eighth of a round body touches at a time."""

LEVEL = 1e-6
"""Difference of places, as a share of a piece's longest side, that counts as rounding."""


class Partition(NamedTuple):
    """Nodes (k,), the part of each (k,), and the middles of the parts at rest (parts, 3)."""

    nodes: IntArray
    labels: Labels
    middles: FloatArray


def clustered_patches(
    view: BodyView,
    *,
    count: int = 6,
    region: str | None = None,
    parts: int | None = None,
    last: tuple[Patch, ...] = (),
) -> tuple[Patch, ...]:
    """At most ``count`` patches of the character; none where the scene has no ground.

    Parts that touch come first, then the nearest to the ground. Where more parts touch than there
    are patches, those stay that were patches before, and others come by their distance from these.
    The other parts lend their nodes to the nearest chosen one. Patches are ordered by
    ``Patch.part``.

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
    near = measure(view, ground, [division.nodes])
    touching = view.touching[division.nodes]
    chosen = _choose(division, near, touching, count, [patch.part for patch in last])
    owners = _owners(division, chosen)
    patches = patches_of(view, ground, near.divided(owners))
    return tuple(
        unchecked_copy(patch, part=part)
        for patch, part in zip(patches, chosen.tolist(), strict=True)
    )


@lru_cache(maxsize=8)
def partition(mesh: TetMesh, nodes: bytes, parts: int) -> Partition:
    """Divide surface nodes at rest into parts of about the same area.

    A piece is cut across the longest side of its box, so that the areas are as the numbers of parts
    on either side; where the cuts lie does not hang on the mesh, but for the width of a triangle.
    """
    chosen = np.frombuffer(nodes, np.int32)
    points, weights = mesh.points[chosen], rest_areas(mesh, nodes)
    if not weights.any():
        weights = np.ones(len(chosen))
    labels = np.zeros(len(chosen), dtype=np.intp)
    pieces, done = [(np.arange(len(chosen)), parts)], 0
    while pieces:
        piece, count = pieces.pop()
        first = np.zeros(len(piece), dtype=bool)
        if count > 1:
            first = _one_side(points[piece], weights[piece], (count // 2) / count)
        if not first.any():
            labels[piece] = done
            done += 1
            continue
        pieces += [(piece[~first], count - count // 2), (piece[first], count // 2)]
    sizes = np.maximum(np.bincount(labels, weights), TINY)
    middles = [np.bincount(labels, weights * along) / sizes for along in points.T]
    return Partition(chosen, labels, np.stack(middles, axis=1))


def _one_side(points: FloatArray, weights: FloatArray, share: float) -> npt.NDArray[np.bool_]:
    """Which nodes (k,) lie on the lower side of a cut that leaves about a share of the weight.

    No cut parts nodes that are level with each other; none at all is on that side where all are.
    """
    sides = np.ptp(points, axis=0)
    along = points[:, int(np.argmax(sides > (1.0 - LEVEL) * sides.max()))]
    order = np.argsort(along, kind="stable")
    steps = np.diff(along[order]) > LEVEL * sides.max()
    below = np.cumsum(weights[order])[:-1] / max(float(weights.sum()), TINY)
    off = np.where(steps, np.abs(below - share), np.inf)
    lower = np.zeros(len(points), dtype=bool)
    if steps.any():
        lower[order[: int(np.argmin(np.round(off, 9))) + 1]] = True
    return lower


def _choose(
    division: Partition,
    near: NearSurface,
    touching: npt.NDArray[np.bool_],
    count: int,
    last: list[int | None],
) -> Labels:
    """Ascending parts that become patches.

    Areas do not matter, so that none gives way to another that touches a little more.
    """
    parts = len(division.middles)
    touched = np.unique(division.labels[touching])
    if len(touched) > count:
        known = set(last)
        kept = [i for i, part in enumerate(touched.tolist()) if part in known]
        return np.sort(touched[_spread(division.middles[touched], count, kept[:count])])
    least = _least_gaps(division, near)
    least[touched] = -np.inf
    return np.sort(np.argsort(least, kind="stable")[: min(count, parts)])


def _least_gaps(division: Partition, near: NearSurface) -> FloatArray:
    least = np.full(len(division.middles), np.inf)
    np.minimum.at(least, division.labels, near.gaps)
    return least


def _owners(division: Partition, chosen: Labels) -> Labels:
    """(k,): the part whose patch takes each node, that of the nearest chosen part.

    Parts lend their nodes whether they touch or not: these begin to count as they come near.
    """
    nearest = chosen[_distances(division.middles, division.middles[chosen]).argmin(axis=1)]
    nearest[chosen] = chosen
    return np.asarray(nearest[division.labels])


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
