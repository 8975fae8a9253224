"""How much each node of a surface counts in a contact: a quadrature, continuous in the state.

A patch is a mean over an area, not over nodes. A node counts by the surface around it, projected on
the ground, and by how near it comes: its share falls by e over a reach that belongs to the body.
What bore the last step counts as it bore: as a patch is loaded, its shares go over to those of the
normal impulse, so that the patch acts where the ground did. No node enters or leaves such a mean at
once, and a finer mesh is a finer quadrature of the same mean (docs/method.md section 4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from warp_softbody.arrays import FloatArray, cross_rows
from warp_softbody.body.mesh import TetMesh
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.world.ground import Ground
from warp_softbody.world.view import BodyView

IntArray = npt.NDArray[np.int32]
Places = npt.NDArray[np.intp]

TINY = np.finfo(float).tiny
"""Keeps what is zero over zero at zero."""

REACH = 0.01
"""L: over this height a node's share falls by e. Shorter, and
a mesh has to be finer to know an edge that tips; longer, and a tilted patch acts far from it."""

LOADED = 0.05
"""m g dt: impulse at which a patch weighs half by what its nodes bore. The ends are a patch that
bears nothing and one that bears the body; with 0.002 to 0.1 plans come as near to the step."""

UPRIGHT_SHARE = 0.01
"""Least share of its area with which a node counts, so that a vertical face still has a mean."""


DENSE = 20_000
"""Entries up to which a matrix that is mostly zeros is kept whole: products then take less time."""


class NearSurface(NamedTuple):
    """Parts of the surface and what is known of their nodes in a step, part after part.

    Attributes:
        nodes: (k,), of the first part, then of the next; parts may have nodes in common.
        begins: (p,), where in them each part begins; none is empty.
        parts: (k,), the number of each node's part.
        gaps: (k,) m, signed distances from the ground.
        normals: (k, 3), of the ground.
        areas: (k,) m^2, of the part around each node, projected on the ground.
        borne: (k,) N s, normal impulses of the ground in the last step.
    """

    nodes: IntArray
    begins: Places
    parts: Places
    gaps: FloatArray
    normals: FloatArray
    areas: FloatArray
    borne: FloatArray

    def of_nodes(self, of_parts: FloatArray) -> FloatArray:
        """Values (p, ...) of the parts for each node of theirs, (k, ...)."""
        return np.asarray(of_parts[self.parts])

    def sums(self, of_nodes: FloatArray) -> FloatArray:
        """Sums (p, ...) over the parts of values (k, ...) of the nodes."""
        return np.asarray(np.add.reduceat(of_nodes, self.begins, axis=0))

    def divided(self, owners: Places) -> NearSurface:
        """The nodes in other parts, whose numbers (k,) are given, in ascending order."""
        order = np.argsort(owners, kind="stable")
        new = np.diff(owners[order], prepend=-1) > 0
        return NearSurface(
            nodes=self.nodes[order],
            begins=np.flatnonzero(new),
            parts=np.cumsum(new) - 1,
            gaps=self.gaps[order],
            normals=self.normals[order],
            areas=self.areas[order],
            borne=self.borne[order],
        )


def measure(view: BodyView, ground: Ground, parts: Sequence[IntArray]) -> NearSurface:
    """What is known of parts of the character's surface, each given by its nodes.

    Parts that have nodes in common share what these bore by their areas around them.
    """
    known = surface_parts(view.scene.character.mesh, tuple(part.tobytes() for part in parts))
    nodes = known.nodes
    gaps, normals = ground.measure(view.positions[nodes])
    crosses = _crosses(view.positions, known.faces)
    sized = np.empty((len(crosses), 4))
    sized[:, :3] = crosses
    sized[:, 3] = np.sqrt(np.add.reduce(crosses * crosses, axis=1))
    around = known.gather @ sized
    facing = -np.add.reduce(around[:, :3] * normals, axis=1)
    areas = np.maximum(facing, UPRIGHT_SHARE * around[:, 3])
    borne = np.zeros(len(nodes))
    if len(view.impulses):
        borne = np.maximum(np.add.reduce(view.impulses[nodes] * normals, axis=1), 0.0)
        if len(known.begins) > 1:
            every = np.bincount(nodes, areas, view.node_count)[nodes]
            borne *= areas / np.maximum(every, TINY)
    return NearSurface(nodes, known.begins, known.parts, gaps, normals, areas, borne)


class Shares(NamedTuple):
    """What parts of the surface make.

    Attributes:
        nodes: (k,) shares of the nodes, sum one in each part.
        gaps: (p,) m, of the lowest node of each; they go over to means of what bears, like shares.
        areas: (p,) of what all parts have within reach of the lowest node of all, sum one.
    """

    nodes: FloatArray
    gaps: FloatArray
    areas: FloatArray


def shares_of(view: BodyView, near: NearSurface) -> Shares:
    """How much each node of a part counts in it, and each part among all."""
    reach = REACH * BodyUnits.of(view).length
    lowest = np.minimum.reduceat(near.gaps, near.begins)
    above = near.gaps - near.of_nodes(lowest)
    reached = near.areas * np.exp(above / -reach)
    sizes = near.sums(reached)
    if not sizes.all():
        # parts without any surface, as within the body
        reached = np.where(near.of_nodes(sizes) > 0.0, reached, above <= 0.0)
    shares = reached / near.of_nodes(near.sums(reached))
    areas = sizes * np.exp((lowest.min() - lowest) / reach)
    areas = areas / areas.sum() if areas.any() else np.full(len(areas), 1.0 / len(areas))
    impulses = near.sums(near.borne)
    if not impulses.any():
        return Shares(shares, lowest, areas)
    light = LOADED * view.weight * view.time_step
    loaded = impulses / np.maximum(impulses + light, TINY)
    bearing = near.borne * near.of_nodes(loaded / np.maximum(impulses, TINY))
    gaps = (1.0 - loaded) * lowest + near.sums(bearing * near.gaps)
    return Shares(near.of_nodes(1.0 - loaded) * shares + bearing, gaps, areas)


def rest_areas(mesh: TetMesh, nodes: bytes) -> FloatArray:
    """Areas (k,) m^2 of the rest surface around nodes, int32."""
    known = surface_parts(mesh, (nodes,))
    areas: FloatArray = known.gather @ np.linalg.norm(_crosses(mesh.points, known.faces), axis=1)
    return areas


def _crosses(positions: FloatArray, faces: IntArray) -> FloatArray:
    """Twice the outward area vectors of triangles (f, 3), (f, 3) m^2."""
    a, b, c = positions[faces.T]
    return cross_rows(b - a, c - a)


class SurfaceParts(NamedTuple):
    """Nodes, where parts begin, and parts (`NearSurface`), faces (f, 3) and who has which (k, f).

    Each corner of a face takes a sixth of the cross product, which is a third of the area.
    """

    nodes: IntArray
    begins: Places
    parts: Places
    faces: IntArray
    gather: Any


@lru_cache(maxsize=64)
def surface_parts(mesh: TetMesh, parts: tuple[bytes, ...]) -> SurfaceParts:
    """What is known of parts of a surface, each given by its nodes, int32."""
    nodes = [np.frombuffer(part, np.int32) for part in parts]
    found = [_faces_of(mesh, own) for own in nodes]
    counts = np.array([len(own) for own in nodes])
    gather = sp.csr_array(sp.block_diag([gather for _, gather in found], format="csr"))
    return SurfaceParts(
        np.concatenate(nodes),
        np.cumsum(counts) - counts,
        np.repeat(np.arange(len(counts)), counts),
        np.concatenate([faces for faces, _ in found]),
        gather if math.prod(gather.shape) > DENSE else gather.toarray(),
    )


def _faces_of(mesh: TetMesh, nodes: IntArray) -> tuple[IntArray, sp.csr_array]:
    """Faces (f, 3) of a set of nodes, and the matrix (k, f) that shares them out.

    These are the surface's triangles within the set, so that a refined region has the same area;
    those around it where it has none, as an edge has.
    """
    within = np.isin(mesh.surface, nodes)
    inside = within.all(axis=1)
    faces = mesh.surface[inside if inside.any() else within.any(axis=1)]
    place = np.full(len(mesh.points), -1)
    place[nodes] = np.arange(len(nodes))
    rows, columns = place[faces].ravel(), np.repeat(np.arange(len(faces)), 3)
    known = rows >= 0
    shape = (len(nodes), len(faces))
    entries = (np.full(int(known.sum()), 1.0 / 6.0), (rows[known], columns[known]))
    return faces, sp.csr_array(entries, shape=shape)
