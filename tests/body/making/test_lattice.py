"""Isosurface stuffing: what comes out fills what went in, with tets of bounded shape."""

from __future__ import annotations

import numpy as np
import pytest

from warp_softbody.arrays import FloatArray
from warp_softbody.body.making.graded_lattice import graded_lattice
from warp_softbody.body.making.lattice import Distance, stuff
from warp_softbody.body.making.octree import Octree
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
    points, tets = stuff(distance, Octree.around(-half, half, spacing))
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
    one, other = (stuff(ball, Octree.around(-ONE, ONE, 0.4)) for _ in range(2))
    assert count_parts(one.tets) == 1
    assert np.array_equal(one.points, other.points)
    assert np.array_equal(one.tets, other.tets)


def test_the_lattice_fills_its_box() -> None:
    low, high = np.array([0.0, 0.0, 0.0]), np.array([1.0, 0.6, 0.3])
    nodes, tets = graded_lattice(Octree.around(low, high, 0.2))
    volumes = abs(tet_volumes(nodes, tets.astype(np.int32)))
    assert volumes == pytest.approx(np.full(len(tets), 0.2**3 / 12.0))
    # Where two cells lie to both sides of each face, all of it is filled.
    inner = np.ptp(nodes, axis=0) - 0.2
    assert volumes.sum() > inner.prod()


def test_flat_soles_come_out_flat() -> None:
    def block(places: FloatArray) -> FloatArray:
        return np.asarray((np.array([0.5, 0.4, 0.31]) - abs(places)).min(axis=1))

    half = np.array([0.5, 0.4, 0.31])
    points, tets = stuff(block, Octree.around(-half, half, 0.13))
    corners = points[surface_triangles(tets)]
    sole = corners[(abs(corners[:, :, 2] + 0.31) < 1e-9).all(axis=1)]
    normals = np.cross(sole[:, 1] - sole[:, 0], sole[:, 2] - sole[:, 0])
    # all of the block's underside but a rim of less than a cell, where the lattice cuts its edges
    assert 0.5 * np.linalg.norm(normals, axis=1).sum() > (1.0 - 0.2) * (0.8 - 0.2)


def refined_about(places: FloatArray, levels: int) -> Octree:
    """A grid over [-1, 1]^3 with small cubes about places."""
    tree = Octree.around(-ONE, ONE, 0.4)
    tree.refine(*([places] * levels))
    return tree


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_cubes_of_several_sizes_fill_the_same_box_without_gaps(levels: int) -> None:
    rng = np.random.default_rng(levels)
    whole = graded_lattice(Octree.around(-ONE, ONE, 0.4))
    tree = refined_about(rng.uniform(-0.5, 0.5, (4, 3)), levels)
    nodes, tets = graded_lattice(tree)
    volumes = abs(tet_volumes(nodes, tets.astype(np.int32)))
    total = abs(tet_volumes(whole.nodes, whole.tets.astype(np.int32))).sum()
    assert volumes.min() > 0.99 * tree.least_edge**3 / 48.0
    assert volumes.sum() == pytest.approx(total)
    # each face is shared by two tets but for those at the box, as a gap or an overlap would show
    assert tet_faces(tets.astype(np.int32)).counts.max() == 2
    outer = nodes[surface_triangles(tets.astype(np.int32))].mean(axis=1)
    low, high = tree.origin, tree.origin + tree.counts * tree.spacing
    rim = np.minimum(outer - low, high - outer).min(axis=1)
    assert rim.max() < 1.01 * tree.spacing


@pytest.mark.parametrize("levels", [1, 2, 3])
def test_a_ball_in_cubes_of_several_sizes(levels: int) -> None:
    tree = refined_about(np.array([[0.7, 0.0, 0.7], [-0.6, 0.8, 0.0]]), levels)
    points, tets = stuff(ball, tree)
    assert tet_volumes(points, tets).min() > 0.0
    assert tet_faces(tets).counts.max() == 2
    assert not len(same_side_pairs(tets))
    assert count_parts(tets) == 1
    assert tet_volumes(points, tets).sum() == pytest.approx(4.0 / 3.0 * np.pi, rel=0.1)
    angles = dihedral_angles(points, tets)
    assert angles.min() > 9.0
    assert angles.max() < 160.0
