"""Isosurface stuffing: what comes out fills what went in, with tets of bounded shape."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.lattice import Distance, body_centred_lattice, stuff
from warp_softbody.body.mesh_geometry import (
    count_parts,
    dihedral_angles,
    same_side_pairs,
    surface_triangles,
    tet_faces,
    tet_volumes,
)


def ball(places: FloatArray) -> FloatArray:
    """Distance to the unit sphere."""
    return np.asarray(1.0 - np.linalg.norm(places, axis=1))


def bent(places: FloatArray) -> FloatArray:
    """Distance to a ring of radius 1 and thickness 0.5."""
    around = np.hypot(places[:, 0], places[:, 1]) - 1.0
    return np.asarray(0.25 - np.hypot(around, places[:, 2]))


ONE = np.ones(3)


@pytest.mark.parametrize("spacing", [0.5, 0.31, 0.17])
@pytest.mark.parametrize(
    ("distance", "half", "volume"),
    [(ball, ONE, 4.0 / 3.0 * np.pi), (bent, np.array([1.25, 1.25, 0.25]), 2.0 * np.pi**2 / 16.0)],
)
def test_fills_what_lies_inside(
    distance: Distance, half: FloatArray, volume: float, spacing: float
) -> None:
    points, tets = stuff(distance, -half, half, spacing)
    volumes = tet_volumes(points, tets)
    assert volumes.min() > 1e-3 * spacing**3
    assert tet_faces(tets).counts.max() == 2
    assert not len(same_side_pairs(tets))
    # Chords cut off what bulges over them: spacing^2 / 8 R of it, times two over the area.
    assert volumes.sum() == pytest.approx(volume, rel=2.0 * spacing**2 / half[2])
    assert abs(distance(points[surface_triangles(tets)].reshape(-1, 3))).max() < 0.2 * spacing
    # The paper's bound is 10.7 degrees for its safe values; its own rule for diagonals is not ours.
    angles = dihedral_angles(points, tets)
    assert angles.min() > 9.0
    assert angles.max() < 160.0


def test_a_ball_is_one_piece_and_the_same_each_time() -> None:
    one, other = (stuff(ball, -ONE, ONE, 0.4) for _ in range(2))
    assert count_parts(one.tets) == 1
    assert np.array_equal(one.points, other.points)
    assert np.array_equal(one.tets, other.tets)


def test_the_lattice_fills_its_box() -> None:
    low, high = np.array([0.0, 0.0, 0.0]), np.array([1.0, 0.6, 0.3])
    nodes, tets = body_centred_lattice(low, high, 0.2)
    volumes = abs(tet_volumes(nodes, tets.astype(np.int32)))
    assert volumes == pytest.approx(np.full(len(tets), 0.2**3 / 12.0))
    # Where two cells lie to both sides of each face, all of it is filled.
    inner = np.ptp(nodes, axis=0) - 0.2
    assert volumes.sum() > inner.prod()


def test_flat_soles_come_out_flat() -> None:
    def block(places: FloatArray) -> FloatArray:
        return np.asarray((np.array([0.5, 0.4, 0.31]) - abs(places)).min(axis=1))

    half = np.array([0.5, 0.4, 0.31])
    points, tets = stuff(block, -half, half, 0.13)
    corners = points[surface_triangles(tets)]
    sole = corners[(abs(corners[:, :, 2] + 0.31) < 1e-9).all(axis=1)]
    normals = np.cross(sole[:, 1] - sole[:, 0], sole[:, 2] - sole[:, 0])
    # all of the block's underside but a rim of less than a cell, where the lattice cuts its edges
    assert 0.5 * np.linalg.norm(normals, axis=1).sum() > (1.0 - 0.2) * (0.8 - 0.2)
