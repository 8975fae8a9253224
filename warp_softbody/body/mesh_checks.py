"""The arrays of a mesh are repaired where there is one right answer, and refused otherwise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.close_points import first_of_close
from warp_softbody.body.mesh_geometry import (
    IntArray,
    count_parts,
    same_side_pairs,
    tet_faces,
    tet_volumes,
)
from warp_softbody.errors import MeshError

MERGE_TOLERANCE = 1e-9
"""Points closer than this times the diagonal of the box are one point."""

FLAT_TOLERANCE = 1e-12
"""A tet of less volume than this times its longest edge cubed is flat."""


LARGEST_COORDINATE = 1e9
"""m, beyond which a point is refused; volumes and their sums stay far from overflow."""


class CleanArrays(NamedTuple):
    """Arrays that keep every promise of `TetMesh`.

    Attributes:
        points: (n, 3) float64 m.
        tets: (m, 4) int32.
        node_of: (given points,) int32 node that each given point became, -1 for a dropped one.
        notes: a sentence each on what was dropped or merged.
    """

    points: FloatArray
    tets: IntArray
    node_of: IntArray
    notes: tuple[str, ...]


def clean_arrays(
    points: npt.ArrayLike, tets: npt.ArrayLike, *, source: str, allow_parts: bool
) -> CleanArrays:
    """Repair what has one right answer and refuse the rest.

    Repaired: byte order, duplicate and unused points, orientation.

    Raises:
        MeshError: wrong shapes, values that are not finite or too large, indices out of range, flat
            or overlapping tets, no tets, or several parts without `allow_parts`.
    """
    given, corners = checked_arrays(points, tets, source=source)
    clean = _numbered_anew(given, corners, source)
    _check_distinct(clean.tets, source)
    clean = clean._replace(tets=_oriented(clean.points, clean.tets, source))
    _check_faces(clean.tets, source)
    parts = 1 if allow_parts else count_parts(clean.tets)
    if parts != 1:
        raise MeshError(
            f"{source}: the tets form {parts} separate parts, but a body is one part; "
            f"pass allow_parts=True to accept them"
        )
    return clean


def checked_arrays(
    points: npt.ArrayLike, tets: npt.ArrayLike, *, source: str
) -> tuple[FloatArray, IntArray]:
    """Copies of the arrays in the right types, nothing repaired.

    Raises:
        MeshError: wrong shapes, values that are not finite, indices out of range, or no tets.
    """
    given, corners = _checked_points(points, source), _checked_tets(tets, source)
    _check_range(given, corners, source)
    return given, corners


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
    wrong = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if wrong.size:
        place = array[wrong[0]].tolist()
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


def _check_range(points: FloatArray, tets: IntArray, source: str) -> None:
    highest, count = int(tets.max()), len(points)
    if highest >= count:
        raise MeshError(f"{source}: tets hold point index {highest}, but there are {count} points")
    far = np.zeros(count, dtype=bool)
    far[tets] = True
    wrong = np.flatnonzero(far & (np.abs(points) > LARGEST_COORDINATE).any(axis=1))
    if wrong.size:
        raise MeshError(
            f"{source}: point {wrong[0]} lies too far from the origin: "
            f"{points[wrong[0]].tolist()}, but at most {LARGEST_COORDINATE:g} m are taken"
        )


def _numbered_anew(points: FloatArray, tets: IntArray, source: str) -> CleanArrays:
    """Drop points that no tet uses, merge those within the tolerance, keep the others' order."""
    used = np.unique(tets)
    diagonal = float(np.linalg.norm(np.ptp(points[used], axis=0)))
    first = first_of_close(points[used], MERGE_TOLERANCE * diagonal)
    kept, node = np.unique(first, return_inverse=True)
    node_of = np.full(len(points), -1, dtype=np.int32)
    node_of[used] = node
    notes = []
    if len(used) < len(points):
        notes.append(
            f"{source}: {len(points) - len(used)} of {len(points)} points are in no tet and were "
            f"dropped, which shifts the numbers of others; TetMesh.nodes_of maps them"
        )
    if len(kept) < len(used):
        notes.append(
            f"{source}: {len(used) - len(kept)} of {len(points)} points were merged with others "
            f"at the same place, which shifts the numbers of others; TetMesh.nodes_of maps them"
        )
    return CleanArrays(points[used][kept], node_of[tets], node_of, tuple(notes))


def _check_distinct(tets: IntArray, source: str) -> None:
    ordered = np.sort(tets, axis=1)
    wrong = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if wrong.size:
        raise MeshError(f"{source}: tet {wrong[0]} has no volume: two of its corners are one point")


def _oriented(points: FloatArray, tets: IntArray, source: str) -> IntArray:
    """Swap two corners of every tet of negative volume; refuse flat ones."""
    volumes = tet_volumes(points, tets)
    corners = points[tets]
    longest = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=3).max(axis=(1, 2))
    flat = np.flatnonzero(np.abs(volumes) <= FLAT_TOLERANCE * longest**3)
    if flat.size:
        raise MeshError(
            f"{source}: tet {flat[0]} has no volume ({volumes[flat[0]]:.3g} m^3): "
            f"its four corners lie in one plane"
        )
    turned: IntArray = np.where((volumes < 0.0)[:, None], tets[:, [0, 1, 3, 2]], tets)
    return turned


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
