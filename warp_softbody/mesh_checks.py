"""What `TetMesh.from_arrays` repairs, and what it refuses in one sentence naming the source."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from warp_softbody.errors import MeshError
from warp_softbody.mesh_geometry import (
    FloatArray,
    IntArray,
    count_parts,
    same_side_pairs,
    tet_faces,
    tet_volumes,
)

MERGE_TOLERANCE = 1e-9
"""Points closer than this times the diagonal of the box are one point."""

FLAT_TOLERANCE = 1e-12
"""A tet of less volume than this times its longest edge cubed is flat."""


LARGEST_COORDINATE = 1e9
"""m, beyond which a point is refused; volumes and their sums stay far from overflow."""


class CleanArrays(NamedTuple):
    """Points (n, 3) float64 m and tets (m, 4) int32 that keep every promise of `TetMesh`."""

    points: FloatArray
    tets: IntArray


def clean_arrays(
    points: npt.ArrayLike, tets: npt.ArrayLike, *, source: str, allow_parts: bool
) -> CleanArrays:
    """Repair what has one right answer and refuse the rest.

    Repaired: byte order, duplicate and unused points, orientation.

    Raises:
        MeshError: wrong shapes, values that are not finite, indices out of range, flat or
            overlapping tets, no tets, or several parts without `allow_parts`.
    """
    clean = checked_arrays(points, tets, source=source)
    clean = _without_unused(_merged(clean))
    _check_distinct(clean, source)
    clean = _oriented(clean, source)
    _check_faces(clean.tets, source)
    parts = 1 if allow_parts else count_parts(clean.tets)
    if parts != 1:
        raise MeshError(
            f"{source}: the tets form {parts} separate parts, but a body is one part; "
            f"pass allow_parts=True to accept them"
        )
    return clean


def checked_arrays(points: npt.ArrayLike, tets: npt.ArrayLike, *, source: str) -> CleanArrays:
    """Copies of the arrays in the right types, nothing repaired.

    Raises:
        MeshError: wrong shapes, values that are not finite, indices out of range, or no tets.
    """
    clean = CleanArrays(_checked_points(points, source), _checked_tets(tets, source))
    _check_range(clean, source)
    return clean


def _checked_points(points: npt.ArrayLike, source: str) -> FloatArray:
    try:
        given = np.asarray(points)
    except Exception as error:
        # rows of unequal length, or an object whose own conversion fails
        raise MeshError(f"{source}: points are not an array of numbers: {error}") from error
    if given.dtype.kind not in "iuf":
        raise MeshError(f"{source}: points are not numbers, but of the type {given.dtype}")
    array = np.array(given, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{source}: points must have shape (n, 3), got {array.shape}")
    wrong = np.flatnonzero(~(np.abs(array) < LARGEST_COORDINATE).all(axis=1))
    if wrong.size:
        place = array[wrong[0]].tolist()
        if np.isfinite(place).all():
            raise MeshError(
                f"{source}: point {wrong[0]} is further away than {LARGEST_COORDINATE:g} m: {place}"
            )
        raise MeshError(f"{source}: point {wrong[0]} is not finite: {place}")
    return array


def _checked_tets(tets: npt.ArrayLike, source: str) -> IntArray:
    try:
        array = np.asarray(tets)
    except Exception as error:
        raise MeshError(f"{source}: tets are not an array: {error}") from error
    if array.size == 0:
        raise MeshError(f"{source}: the mesh is empty: it has no tets")
    if array.ndim != 2 or array.shape[1] != 4:
        raise MeshError(f"{source}: tets must have shape (m, 4), got {array.shape}")
    if array.dtype.kind not in "iu":
        raise MeshError(f"{source}: tets must hold integers, got dtype {array.dtype}")
    low, high = int(array.min()), int(array.max())
    if low < 0 or high > np.iinfo(np.int32).max:
        raise MeshError(
            f"{source}: tets hold point index {low if low < 0 else high}, which is out of range"
        )
    return np.array(array, dtype=np.int32)


def _check_range(clean: CleanArrays, source: str) -> None:
    highest, count = int(clean.tets.max()), len(clean.points)
    if highest >= count:
        raise MeshError(f"{source}: tets hold point index {highest}, but there are {count} points")


def _merged(clean: CleanArrays) -> CleanArrays:
    """Give all points within the tolerance the index of the first of them."""
    points, tets = clean
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    pairs = KDTree(points).query_pairs(MERGE_TOLERANCE * diagonal, output_type="ndarray")
    if not len(pairs):
        return clean
    count = len(points)
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, label = connected_components(links, directed=False)
    _, first = np.unique(label, return_index=True)
    return CleanArrays(points, np.asarray(first[label][tets], dtype=np.int32))


def _without_unused(clean: CleanArrays) -> CleanArrays:
    """Drop points that no tet uses, keeping the order of the others."""
    used, compact = np.unique(clean.tets, return_inverse=True)
    return CleanArrays(
        clean.points[used], np.asarray(compact, dtype=np.int32).reshape(clean.tets.shape)
    )


def _check_distinct(clean: CleanArrays, source: str) -> None:
    ordered = np.sort(clean.tets, axis=1)
    wrong = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if wrong.size:
        raise MeshError(f"{source}: tet {wrong[0]} has no volume: two of its corners are one point")


def _oriented(clean: CleanArrays, source: str) -> CleanArrays:
    """Swap two corners of every tet of negative volume; refuse flat ones."""
    points, tets = clean
    volumes = tet_volumes(points, tets)
    corners = points[tets]
    longest = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2))
    flat = np.flatnonzero(np.abs(volumes) <= FLAT_TOLERANCE * longest**3)
    if flat.size:
        raise MeshError(
            f"{source}: tet {flat[0]} has no volume ({volumes[flat[0]]:.3g} m^3): "
            f"its four corners lie in one plane"
        )
    turned = np.where((volumes < 0.0)[:, None], tets[:, [0, 1, 3, 2]], tets)
    return CleanArrays(points, turned)


def _check_faces(tets: IntArray, source: str) -> None:
    """Refuse tets that overlap: at most two may share a face, one on each side."""
    crowded = int((tet_faces(tets).counts > 2).sum())
    if crowded:
        raise MeshError(f"{source}: {crowded} faces are shared by more than two tets")
    overlapping = same_side_pairs(tets)
    if len(overlapping):
        first, second = overlapping[0]
        raise MeshError(
            f"{source}: tets {first} and {second} overlap: "
            f"they lie on the same side of a shared face"
        )
