"""Limbs of a body by its shape: arcs of the Reeb graph of the distance from its middle.

Nodes are grouped into shells of like geodesic distance from the body's middle; each connected piece
of a shell is a slice of the body, and slices in a row are a limb.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.body.mesh_refinement import refine

Numbers = npt.NDArray[np.int64]

SHELL = 2.0
"""Thickness of a shell in mean edges of the refined mesh."""

FEW_NODES = 20_000
"""A mesh of fewer nodes is refined, so that shells are thin and have nodes within the body."""

MOST_SOURCES = 120
"""Nodes among which the middle is looked for."""

MIDDLE = 1.08
"""Times the least distance of a farthest node that the middle's may have."""

LEAST_SLENDERNESS, LEAST_REACH = 1.5, 0.4
"""A limb is longer than this many radii of its own slices, and of the body where it begins."""

LEAST_OF_BODY = 0.7
"""Length of all limbs over the body's longest side below which it is taken as one limb."""

STRAIGHT = 0.5
"""Share of the way through the body that the line through a limb's slices must have: the rim of a
disc is no limb."""


@dataclass(frozen=True)
class Limb:
    """A row of slices.

    Attributes:
        axis: (k, 3) m, from where the limb begins to its tip.
        nodes: (n,) of its slices, ascending.
        radius: of the mean slice, m.
        ends: whether it ends in a tip rather than in another branch.
    """

    axis: FloatArray
    nodes: Numbers
    radius: float
    ends: bool

    @property
    def length(self) -> float:
        """Length of the axis, m."""
        return float(np.linalg.norm(np.diff(self.axis, axis=0), axis=1).sum())

    def renumbered(self, kept: Numbers) -> Limb:
        """The limb of a mesh that has only the nodes ``kept`` (n,), ascending, of this one."""
        return replace(self, nodes=np.flatnonzero(np.isin(kept, self.nodes)))


@dataclass(frozen=True)
class _Slices:
    """Pieces of shells.

    Attributes:
        of_node: (n,) slice of each node.
        middles: (k, 3) m, of the slices.
        radii: (k,) m, mean distance from their middles.
        begins: (k,) m, least distance from the body's middle.
        reach: (k,) m, greatest distance from it.
        links: slices that touch each.
    """

    of_node: Numbers
    middles: FloatArray
    radii: FloatArray
    begins: FloatArray
    reach: FloatArray
    links: tuple[frozenset[int], ...]


def find_limbs(mesh: TetMesh) -> tuple[Limb, ...]:
    """Limbs of a body, longest first; of one without limbs its longest way, in one."""
    fine = refine(mesh)[0] if len(mesh.points) < FEW_NODES else mesh
    graph, edge = _edges(fine)
    slices = _slices(fine, graph, _from_middle(fine, graph), SHELL * edge)
    limbs = [_limb(len(mesh.points), slices, row, ends) for row, ends in _rows(slices)]
    kept = [limb for limb in limbs if limb is not None]
    side = float(np.ptp(mesh.bounds, axis=0).max())
    if sum(limb.length for limb in kept) < LEAST_OF_BODY * side:
        return (_whole(mesh),)
    return tuple(sorted(kept, key=lambda limb: -limb.length))


def _edges(mesh: TetMesh) -> tuple[csr_array, float]:
    """Lengths of the mesh's edges as a symmetric graph, and their mean, m."""
    ends = np.concatenate([mesh.tets[:, [a, b]] for a in range(4) for b in range(a)])
    ends = np.unique(np.sort(ends, axis=1), axis=0)
    length = np.linalg.norm(mesh.points[ends[:, 1]] - mesh.points[ends[:, 0]], axis=1)
    shape = (len(mesh.points),) * 2
    half = coo_array((length, ends.T), shape=shape)
    return csr_array(half + half.T), float(length.mean())


def _from_middle(mesh: TetMesh, graph: csr_array) -> FloatArray:
    """Distance (n,) m along edges from the body's middle.

    That is the deepest of the nodes from which no other is much farther than from the best: on the
    body's axis rather than on its skin.
    """
    step = max(1, len(mesh.points) // MOST_SOURCES)
    sources = np.arange(0, len(mesh.points), step)
    found = dijkstra(graph, directed=False, indices=sources)
    farthest = found.max(axis=1)
    near = np.flatnonzero(farthest < MIDDLE * farthest.min())
    skin = cKDTree(mesh.points[mesh.surface_nodes])
    depth = np.asarray(skin.query(mesh.points[sources[near]])[0])
    best: FloatArray = found[near[depth.argmax()]]
    return best


def _slices(mesh: TetMesh, graph: csr_array, distance: FloatArray, shell: float) -> _Slices:
    ends = np.stack(graph.nonzero(), axis=1)
    level = (distance / shell).astype(np.int64)
    count = len(mesh.points)
    same = ends[level[ends[:, 0]] == level[ends[:, 1]]]
    pieces = coo_array((np.ones(len(same)), same.T), shape=(count, count))
    of_node = connected_components(pieces, directed=False)[1].astype(np.int64)
    size = int(of_node.max()) + 1
    mass = lumped_masses(mesh.tets, mesh.volumes, count)
    total = np.bincount(of_node, weights=mass)
    mean = [np.bincount(of_node, weights=mass * mesh.points[:, k]) / total for k in range(3)]
    middles = np.stack(mean, axis=1)
    apart = np.square(mesh.points - middles[of_node]).sum(axis=1)
    radii = np.sqrt(np.bincount(of_node, weights=mass * apart) / total)
    # A slice of few nodes stands for the tets around it.
    radii = np.maximum(radii, 0.3 * shell)
    links: list[set[int]] = [set() for _ in range(size)]
    for one, other in np.unique(of_node[ends], axis=0):
        if one != other:
            links[one].add(int(other))
    reach = np.zeros(size)
    np.maximum.at(reach, of_node, distance)
    begins = np.full(size, np.inf)
    np.minimum.at(begins, of_node, distance)
    return _Slices(of_node, middles, radii, begins, reach, tuple(frozenset(each) for each in links))


def _rows(slices: _Slices) -> list[tuple[list[int], bool]]:
    """Rows of slices from branch to branch or tip, and whether they end in a tip.

    Rows that are short beside the body at their branch are no limbs: their slices join the branch,
    and what was a branch for them alone is one no more.
    """
    links = {number: set(near) for number, near in enumerate(slices.links)}
    middle = int(slices.reach.argmin())
    while True:
        rows = _walk(links, middle)
        stubs = [row for row, ends in rows if ends and not _is_long(slices, row)]
        if not stubs:
            return rows
        for number in (number for row in stubs for number in row[1:]):
            for near in links.pop(number):
                if near in links:
                    links[near].discard(number)


def _is_long(slices: _Slices, row: list[int]) -> bool:
    length = float(slices.reach[row[-1]] - slices.begins[row[1]])
    own = float(slices.radii[row[1:]].mean())
    return length >= max(LEAST_SLENDERNESS * own, LEAST_REACH * float(slices.radii[row[0]]))


def _walk(links: dict[int, set[int]], middle: int) -> list[tuple[list[int], bool]]:
    """Rows between slices that do not have two neighbours, each once, outwards from the middle."""
    rows: list[tuple[list[int], bool]] = []
    waiting, seen = [middle], {middle}
    done: set[frozenset[int]] = set()
    while waiting:
        branch = waiting.pop(0)
        for first in sorted(links[branch]):
            if frozenset((branch, first)) in done:
                continue
            row = [branch, first]
            while len(links[row[-1]]) == 2 and row[-1] != middle:
                (following,) = links[row[-1]] - {row[-2]} or {row[-2]}
                row.append(following)
            done |= {frozenset(pair) for pair in pairwise(row)}
            ends = len(links[row[-1]]) == 1
            rows.append((row, ends))
            if not ends and row[-1] not in seen:
                seen.add(row[-1])
                waiting.append(row[-1])
    return rows


def _limb(count: int, slices: _Slices, row: list[int], ends: bool) -> Limb | None:
    """A limb of a row of slices, if it goes somewhere; ``count`` nodes are the mesh's own."""
    nodes = np.flatnonzero(np.isin(slices.of_node[:count], row[1:]))
    axis = slices.middles[row]
    through = float(slices.reach[row].max() - slices.reach[row].min())
    radius = float(slices.radii[row[1:]].mean())
    limb = Limb(axis, nodes, radius, ends)
    if limb.length < STRAIGHT * through or limb.length < radius:
        return None
    return limb


def _whole(mesh: TetMesh) -> Limb:
    """The body as one limb along its longest way, upwards."""
    mass = lumped_masses(mesh.tets, mesh.volumes, len(mesh.points))
    middle = mass @ mesh.points / mass.sum()
    around = mesh.points - middle
    spread = (around * mass[:, None]).T @ around
    values, ways = np.linalg.eigh(spread)
    way = ways[:, -1] if values[-1] > 1.2 * values[-2] else np.array([0.0, 0.0, 1.0])
    way = way if way[2] >= 0.0 else -way
    along = around @ way
    stations = np.linspace(0.8 * along.min(), 0.8 * along.max(), 5)
    radius = float(np.sqrt(values[0] / mass.sum()) * 2.0)
    everything = np.arange(len(mesh.points))
    return Limb(middle + stations[:, None] * way, everything, radius, ends=True)
