"""Points of a skin are bound to the tets that they lie in, or that come nearest to them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import inverse_edges
from warp_softbody.errors import InputError

INSIDE = 1e-9
"""Distance of a point from a tet, over the body's size, up to which it is in it."""

MOST_OUTSIDE = 0.1
"""Distance of a point from the tets, over the diagonal of their box, beyond which it is refused:
barycentric weights stretch what lies far away."""

_NEAR = 16
_PIECE = 2_000_000
"""Pairs of a point and a tet whose box is tried at once."""


def bind(mesh: TetMesh, points: FloatArray, label: str) -> csr_array[np.float64]:
    """(k, n) barycentric weights of the nodes in each of the points (k, 3) m at rest.

    A point outside has the weights of the nearest tet, of which some are negative, so that it keeps
    its place to it under any affine motion.

    Raises:
        InputError: a point lies further outside than `MOST_OUTSIDE`; ``label`` is whose.
    """
    size = float(np.linalg.norm(np.ptp(mesh.bounds, axis=0)))
    tets = _Tets(mesh)
    chosen, distances = tets.nearest(points, INSIDE * size)
    far = int(np.argmax(distances))
    if distances[far] > MOST_OUTSIDE * size:
        place = ", ".join(f"{value:g}" for value in points[far])
        raise InputError(
            f"{label}: point {far} at ({place}) m lies {distances[far]:.3g} m outside the tets; at "
            f"most {MOST_OUTSIDE * size:.3g} m, a tenth of the body, can be carried along"
        )
    weights = tets.weights(points, chosen)
    rows = np.repeat(np.arange(len(points)), 4)
    columns = np.asarray(mesh.tets)[chosen].reshape(-1)
    shape = (len(points), len(mesh.points))
    return csr_array((weights.reshape(-1), (rows, columns)), shape=shape)


class _Tets:
    """The tets of a mesh, asked for those nearest to points."""

    def __init__(self, mesh: TetMesh) -> None:
        self._corners = np.asarray(mesh.points)[mesh.tets]
        self._inverse = inverse_edges(np.asarray(mesh.points), np.asarray(mesh.tets))
        self._low, self._high = self._corners.min(axis=1), self._corners.max(axis=1)

    def nearest(self, points: FloatArray, inside: float) -> tuple[npt.NDArray[np.intp], FloatArray]:
        """The nearest tet of each point, and its distance, m; up to ``inside`` any tet will do."""
        # few bodies have skins of their own, and it takes a while to load
        from scipy.spatial import cKDTree

        tree = cKDTree(self._corners.mean(axis=1))
        near = tree.query(points, k=min(_NEAR, len(self._corners)))[1].reshape(len(points), -1)
        chosen = np.zeros(len(points), dtype=np.intp)
        best = np.full(len(points), np.inf)
        rows = np.repeat(np.arange(len(points)), near.shape[1])
        self._improve(points, rows, near.reshape(-1), chosen, best)
        # a point of a large tet may be nearer to the middles of many small ones
        left = np.flatnonzero(best > inside)
        pieces = max(1, -(-len(left) * len(self._corners) // _PIECE))
        for piece in np.array_split(left, pieces):
            around = best[piece, None, None]
            place = points[piece][:, None]
            close = (place >= self._low - around) & (place <= self._high + around)
            row, tet = np.nonzero(close.all(axis=2))
            self._improve(points, piece[row], tet, chosen, best)
        return chosen, best

    def weights(self, points: FloatArray, tets: npt.NDArray[np.intp]) -> FloatArray:
        """(k, 4) barycentric weights of each point in a tet."""
        inner = np.einsum("kij,kj->ki", self._inverse[tets], points - self._corners[tets, 0])
        return np.concatenate([1.0 - inner.sum(axis=1, keepdims=True), inner], axis=1)

    def _improve(
        self,
        points: FloatArray,
        rows: npt.NDArray[np.intp],
        tets: npt.NDArray[np.intp],
        chosen: npt.NDArray[np.intp],
        best: FloatArray,
    ) -> None:
        """Try tets for rows of points, and keep those that are nearer than what is chosen.

        The distance is that from the point with weights below zero taken as zero, which is zero
        inside and never less than the true one.
        """
        if not len(rows):
            return
        weights = np.maximum(self.weights(points[rows], tets), 0.0)
        weights /= weights.sum(axis=1, keepdims=True)
        within = np.einsum("kc,kcx->kx", weights, self._corners[tets])
        distance = np.linalg.norm(points[rows] - within, axis=1)
        order = np.lexsort((tets, distance, rows))
        first = order[np.unique(rows[order], return_index=True)[1]]
        better = first[distance[first] < best[rows[first]]]
        chosen[rows[better]], best[rows[better]] = tets[better], distance[better]
