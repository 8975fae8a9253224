"""How much each node of a surface counts in a contact: a quadrature, continuous in the state.

A patch is a mean over an area, not over nodes. A node counts by the surface around it, projected on
the ground, and by how near it comes: its share falls by e over a reach that belongs to the body.
What bore the last step counts as it bore: as a patch is loaded, its shares go over to those of the
normal impulse, so that the patch acts where the ground did. No node enters or leaves such a mean at
once, and a finer mesh is a finer quadrature of the same mean (docs/method.md section 4).
"""

from __future__ import annotations

import math
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
    """Surface nodes and what is known of them in a step.

    Attributes:
        nodes: (k,).
        gaps: (k,) m, signed distances from the ground.
        normals: (k, 3), of the ground.
        areas: (k,) m^2, of the surface around each node, projected on the ground.
        borne: (k,) N s, normal impulses of the ground in the last step.
    """

    nodes: IntArray
    gaps: FloatArray
    normals: FloatArray
    areas: FloatArray
    borne: FloatArray

    def part(self, chosen: npt.NDArray[np.bool_]) -> NearSurface:
        """Those of the nodes that a mask (k,) names."""
        return NearSurface(
            self.nodes[chosen],
            self.gaps[chosen],
            self.normals[chosen],
            self.areas[chosen],
            self.borne[chosen],
        )


def measure(view: BodyView, ground: Ground, nodes: IntArray) -> NearSurface:
    """What is known of some nodes of the character's surface."""
    gaps, normals = ground.measure(view.positions[nodes])
    faces, gather = _faces_of(view.scene.character.mesh, nodes.tobytes())
    crosses = _crosses(view.positions, faces)
    facing = -np.add.reduce((gather @ crosses) * normals, axis=1)
    whole = gather @ np.sqrt(np.add.reduce(crosses * crosses, axis=1))
    borne = np.zeros(len(nodes))
    if len(view.impulses):
        borne = np.maximum(np.add.reduce(view.impulses[nodes] * normals, axis=1), 0.0)
    return NearSurface(nodes, gaps, normals, np.maximum(facing, UPRIGHT_SHARE * whole), borne)


def shares_of(view: BodyView, near: NearSurface) -> tuple[FloatArray, float]:
    """Shares (k,) of the nodes, sum one, and the gap (m) of the patch that they make.

    The gap is that of the lowest node, and goes over to the mean of what bears, like the shares.
    """
    lowest = near.gaps.min()
    shares = reached_areas(view, near, lowest)
    shares /= shares.sum()
    impulse = float(near.borne.sum())
    if not impulse > 0.0:
        return shares, float(lowest)
    loaded = impulse / (impulse + LOADED * view.weight * view.time_step)
    shares = (1.0 - loaded) * shares + (loaded / impulse) * near.borne
    gap = (1.0 - loaded) * lowest + (loaded / impulse) * (near.borne @ near.gaps)
    return shares, float(gap)


def reached_areas(view: BodyView, near: NearSurface, height: float) -> FloatArray:
    """Areas (k,) m^2 that count from a height (m) above the ground on."""
    areas: FloatArray = near.areas * np.exp(
        (height - near.gaps) / (REACH * BodyUnits.of(view).length)
    )
    # nodes without any surface, or all of them out of reach
    return areas if areas.any() else (near.gaps <= height).astype(np.float64)


def rest_areas(mesh: TetMesh, nodes: bytes) -> FloatArray:
    """Areas (k,) m^2 of the rest surface around nodes, int32."""
    faces, gather = _faces_of(mesh, nodes)
    areas: FloatArray = gather @ np.linalg.norm(_crosses(mesh.points, faces), axis=1)
    return areas


def _crosses(positions: FloatArray, faces: IntArray) -> FloatArray:
    """Twice the outward area vectors of triangles (f, 3), (f, 3) m^2."""
    a, b, c = positions[faces.T]
    return cross_rows(b - a, c - a)


@lru_cache(maxsize=64)
def _faces_of(mesh: TetMesh, nodes: bytes) -> tuple[IntArray, Any]:
    """Faces (f, 3) of a set of nodes, and the matrix (k, f) that shares them out.

    These are the surface's triangles within the set, so that a refined region has the same area;
    those around it where it has none, as an edge has. Each corner takes a sixth of the cross
    product, which is a third of the area.
    """
    chosen = np.frombuffer(nodes, np.int32)
    within = np.isin(mesh.surface, chosen)
    inside = within.all(axis=1)
    faces = mesh.surface[inside if inside.any() else within.any(axis=1)]
    place = np.full(len(mesh.points), -1)
    place[chosen] = np.arange(len(chosen))
    rows, columns = place[faces].ravel(), np.repeat(np.arange(len(faces)), 3)
    known = rows >= 0
    shape = (len(chosen), len(faces))
    entries = (np.full(int(known.sum()), 1.0 / 6.0), (rows[known], columns[known]))
    gather = sp.csr_array(entries, shape=shape)
    return faces, gather if math.prod(shape) > DENSE else gather.toarray()
