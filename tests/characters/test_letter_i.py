"""The stored letter I: what its body, regions and muscles promise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from warp_softbody import characters
from warp_softbody.body.character import Character
from warp_softbody.body.mesh_geometry import inverse_edges
from warp_softbody.body.muscles import FiberKind


@pytest.fixture(scope="module")
def letter() -> Character:
    return characters.letter_i()


def test_body(letter: Character) -> None:
    mesh = letter.mesh
    assert letter.name == "letter_i"
    assert mesh.volume == pytest.approx(0.102, abs=1e-6)
    assert abs(len(mesh.tets) - 1066) <= 106
    assert mesh.smallest_dihedral_angle >= 20.0
    assert mesh.part_count == 1
    np.testing.assert_allclose(mesh.bounds, [[-0.25, -0.15, 0.0], [0.25, 0.15, 1.0]], atol=1e-12)


def test_surface_encloses_the_same_body(letter: Character) -> None:
    surface = characters.letter_i_surface()
    assert surface.is_watertight
    assert surface.volume == pytest.approx(letter.mesh.volume, rel=1e-9)
    np.testing.assert_allclose(surface.bounds, letter.mesh.bounds, atol=1e-12)


@pytest.mark.parametrize("axis", [0, 1])
def test_mesh_is_its_own_mirror_image(letter: Character, axis: int) -> None:
    mesh = letter.mesh
    image = mirror_images(mesh.points, axis)
    assert (image >= 0).all()
    mirrored = {tuple(sorted(tet)) for tet in image[mesh.tets].tolist()}
    assert mirrored == {tuple(sorted(tet)) for tet in mesh.tets.tolist()}


def mirror_images(points: NDArray[np.float64], axis: int) -> NDArray[np.int64]:
    """Index (n,) of each node's mirror image, -1 where there is none."""
    index = {tuple(point): i for i, point in enumerate((np.round(points, 12) + 0.0).tolist())}
    mirrored = points.copy()
    mirrored[:, axis] *= -1.0
    return np.array([index.get(tuple(p), -1) for p in (np.round(mirrored, 12) + 0.0).tolist()])


def test_base_is_an_even_grid_with_balanced_patches(letter: Character) -> None:
    base = letter.mesh.points[letter.region("base")]
    np.testing.assert_array_equal(base[:, 2], 0.0)
    across, along = np.unique(base[:, 0].round(9)), np.unique(base[:, 1].round(9))
    np.testing.assert_allclose(across, np.linspace(-0.25, 0.25, 7), atol=1e-8)
    np.testing.assert_allclose(along, np.linspace(-0.15, 0.15, 5), atol=1e-8)
    assert len(base) == 7 * 5
    patches = [letter.mesh.points[letter.region(f"base_patch_{i}")] for i in range(4)]
    signs = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
    for patch, (x, y) in zip(patches, signs, strict=True):
        assert len(patch) == 4 * 3
        np.testing.assert_allclose(patch.mean(axis=0), [0.125 * x, 0.075 * y, 0.0], atol=1e-12)


def test_head(letter: Character) -> None:
    heights = letter.mesh.points[:, 2]
    np.testing.assert_array_equal(letter.region("head"), np.flatnonzero(heights > 0.9 - 1e-9))
    np.testing.assert_allclose(heights[letter.region("head_top")], 1.0, atol=1e-12)
    assert len(letter.region("head_top")) == 35


def test_muscles(letter: Character) -> None:
    (group,) = letter.muscles
    assert letter.segment_count == 48
    assert (group.name, group.strength, group.kernel_width) == ("longitudinal", 4e5, 0.12)
    feet = {tuple(fiber.vertices[0, :2].tolist()) for fiber in group.fibers}
    assert feet == {(x, y) for x in (-0.12, 0.12) for y in (-0.12, 0.12)}
    for fiber in group.fibers:
        assert fiber.kind is FiberKind.LONGITUDINAL and fiber.segment_count == 12
        assert np.ptp(fiber.vertices[:, :2], axis=0).max() == 0.0


def test_fibers_lie_inside(letter: Character) -> None:
    corners = letter.mesh.points[letter.mesh.tets]
    frames = inverse_edges(letter.mesh.points, letter.mesh.tets)
    for vertex in np.concatenate([fiber.vertices for fiber in letter.fibers]):
        weights = np.einsum("tij,tj->ti", frames, vertex - corners[:, 0])
        smallest = np.minimum(weights.min(axis=1), 1.0 - weights.sum(axis=1))
        assert smallest.max() >= -1e-12
