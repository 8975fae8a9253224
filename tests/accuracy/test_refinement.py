"""Refined meshes are the same bodies: volume, surface, regions, shapes."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from tests.support.bodies import box
from warp_softbody import scenes
from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_refinement import refine
from warp_softbody.body.refinement import refined_character
from warp_softbody.errors import InputError
from warp_softbody.world.refined_scene import refined_scene

MESHES = {
    "grid": box((2, 3, 2), (0.2, 0.5, 0.3)),
    "uneven": box((3, 3, 3), (0.3, 0.3, 0.3), jitter=0.2),
    "letter": scenes.make("balance-i").scene.character.mesh,
}


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@pytest.mark.parametrize("levels", [1, 2])
def test_volume_and_surface_are_kept(mesh: TetMesh, levels: int) -> None:
    fine = mesh
    for _ in range(levels):
        fine, _ = refine(fine)
    parts = 8**levels
    assert len(fine.tets) == parts * len(mesh.tets)
    assert len(fine.surface) == 4**levels * len(mesh.surface)
    # sums of some ten thousand rounded terms; an inverted tet would be an error of one
    np.testing.assert_allclose(fine.volume, mesh.volume, rtol=1e-10)
    assert fine.volumes.min() > 0.0
    np.testing.assert_allclose(area(fine), area(mesh), rtol=1e-10)
    np.testing.assert_allclose(fine.bounds, mesh.bounds, atol=1e-12)
    np.testing.assert_array_equal(fine.points[: len(mesh.points)], mesh.points)
    assert fine.part_count == 1


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
def test_tets_share_each_parents_volume_evenly(mesh: TetMesh) -> None:
    """Every tet of a red refinement is an eighth of its parent."""
    fine, _ = refine(mesh)
    parents = np.tile(mesh.volumes, 8)
    np.testing.assert_allclose(fine.volumes, parents / 8.0, rtol=1e-9)


def test_faces_meet_and_shapes_do_not_grow_flat() -> None:
    """A face belongs to at most two tets; the smallest angle stops falling after one level."""
    mesh = MESHES["uneven"]
    angles = []
    for _ in range(3):
        mesh, _ = refine(mesh)
        angles.append(mesh.smallest_dihedral_angle)
    faces = Counter(
        tuple(sorted(face))
        for tet in mesh.tets
        for face in tet[[[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]]
    )
    assert max(faces.values()) == 2
    # similar tets appear again, so that no fourth shape is worse than the third
    assert angles[2] >= angles[1] - 1e-6


def test_regions_and_fixed_nodes_are_those_of_the_same_faces() -> None:
    mesh = box((2, 2, 2), (0.2, 0.2, 0.2))
    along = mesh.points[:, 0]
    low, high = (
        np.flatnonzero(face).astype(np.int32) for face in (along < 1e-9, along > 0.2 - 1e-9)
    )
    body = Character(name="cube", mesh=mesh, regions={"high": high}, fixed=low)
    fine = refined_character(refined_character(body))
    along = fine.mesh.points[:, 0]
    np.testing.assert_array_equal(fine.fixed, np.flatnonzero(along < 1e-9))
    np.testing.assert_array_equal(fine.region("high"), np.flatnonzero(along > 0.2 - 1e-9))


def test_every_body_of_a_scene_is_refined_and_its_muscles_stay() -> None:
    stack = scenes.make("stack", {"count": 2}).scene
    fine = refined_scene(stack, 1)
    counts = [len(body.mesh.tets) for body in stack.characters]
    assert [len(body.mesh.tets) for body in fine.characters] == [8 * count for count in counts]
    letter = scenes.make("balance-i").scene
    assert refined_scene(letter, 1).character.muscles == letter.character.muscles
    assert refined_scene(letter, 0) is letter


def test_levels_are_not_negative() -> None:
    with pytest.raises(InputError, match="0 or more times, got -1"):
        refined_scene(scenes.make("slope").scene, -1)


def area(mesh: TetMesh) -> float:
    a, b, c = (mesh.points[mesh.surface[:, corner]] for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)
