"""What every shipped letter promises of its mesh, its fibres and its regions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from warp_softbody import characters
from warp_softbody.body.character import Character
from warp_softbody.body.mesh_geometry import inverse_edges
from warp_softbody.characters import store
from warp_softbody.characters.coarser_meshes import LONGER_EDGES
from warp_softbody.characters.recipe import AXES
from warp_softbody.errors import InputError

# Tets and muscle segments of the paper's characters.
PAPER = {
    "letter_h": (1901, 52),
    "letter_i": (1066, 48),
    "letter_i_jump": (1066, 104),
    "letter_f": (705, 48),
    "letter_t": (1219, 51),
    "letter_o": (911, 40),
    "letter_x": (1128, 112),
    "letter_i_flat": (620, 26),
}
OWN = {"letter_x_upright": (1240, 112)}
"""The same of those that the paper does not have."""

SIZES = PAPER | OWN
MESHES = {name: "letter_i" if name == "letter_i_jump" else name for name in SIZES}


@pytest.fixture(scope="module", params=SIZES)
def letter(request: pytest.FixtureRequest) -> Character:
    return characters.make(str(request.param))


def test_names() -> None:
    assert set(characters.names()) == set(SIZES)
    coarser = {
        f"{name}_coarse_{n + 1}" for name, edges in LONGER_EDGES.items() for n in range(len(edges))
    }
    assert set(store.names()) == set(MESHES.values()) | coarser
    with pytest.raises(InputError, match="there is no character 'letter_q'; there are: letter_h"):
        characters.make("letter_q")


def test_sizes_are_the_papers(letter: Character) -> None:
    tets, segments = SIZES[letter.name]
    assert abs(len(letter.mesh.tets) - tets) <= 0.15 * tets
    assert letter.segment_count == segments


def test_mesh_is_good_and_whole(letter: Character) -> None:
    recipe = store.load_recipe(MESHES[letter.name])
    mesh = letter.mesh
    assert mesh.smallest_dihedral_angle >= 15.0
    assert mesh.part_count == 1
    # Outlines are stored to 1e-9 m; all else is rounding.
    assert mesh.volume == pytest.approx(recipe.volume, rel=1e-7)
    length = mesh.bounds[1] - mesh.bounds[0]
    assert length[0 if recipe.lying else 2] == pytest.approx(1.0, abs=2e-4)
    assert mesh.bounds[0, 2] == 0.0


def test_surface_encloses_the_same_body(letter: Character) -> None:
    surface = store.load_recipe(MESHES[letter.name]).surface()
    assert surface.is_watertight and surface.is_winding_consistent
    assert abs(surface.volume) == pytest.approx(letter.mesh.volume, rel=1e-9)
    assert surface.volume > 0.0
    np.testing.assert_allclose(surface.bounds, letter.mesh.bounds, atol=1e-12)


def test_mirrors_map_nodes_to_nodes_and_tets_to_tets(letter: Character) -> None:
    mesh = letter.mesh
    middle = mesh.bounds.mean(axis=0)
    for axis in map(AXES.index, store.load_recipe(MESHES[letter.name]).mirrors):
        image = mirror_images(mesh.points - middle, axis)
        assert (image >= 0).all()
        mirrored = {tuple(sorted(tet)) for tet in image[mesh.tets].tolist()}
        assert mirrored == {tuple(sorted(tet)) for tet in mesh.tets.tolist()}


def mirror_images(points: NDArray[np.float64], axis: int) -> NDArray[np.int64]:
    """Index (n,) of each node's mirror image, -1 where there is none."""
    sign = np.where(np.arange(3) == axis, -1.0, 1.0)
    distance = np.linalg.norm(points[:, None] - points[None] * sign, axis=2)
    nearest = distance.argmin(axis=1)
    return np.where(distance.min(axis=1) < 1e-12, nearest, -1)


def test_fibers_lie_inside(letter: Character) -> None:
    corners = letter.mesh.points[letter.mesh.tets]
    frames = inverse_edges(letter.mesh.points, letter.mesh.tets)
    for fiber in letter.fibers:
        # Segments are checked at their ends and three points between.
        place = np.linspace(0.0, fiber.segment_count, 4 * fiber.segment_count + 1)
        ticks = np.arange(fiber.segment_count + 1)
        samples = np.stack([np.interp(place, ticks, v) for v in fiber.vertices.T], axis=1)
        offsets = samples[:, None] - corners[None, :, 0]
        weights = np.einsum("tij,ptj->pti", frames, offsets)
        smallest = np.minimum(weights.min(axis=2), 1.0 - weights.sum(axis=2))
        assert smallest.max(axis=1).min() >= -1e-12, fiber.name


def test_fibers_are_mirrored_as_the_mesh_is(letter: Character) -> None:
    # A helix has no mirror image of its own hand, and the letter F none across.
    middle = letter.mesh.bounds.mean(axis=0)
    for axis in map(AXES.index, store.load_recipe(MESHES[letter.name]).mirrors):
        sign = np.where(np.arange(3) == axis, -1.0, 1.0)
        points = [f.vertices - middle for f in letter.fibers if "helical" not in f.name]
        here = np.concatenate(points)
        distance = np.linalg.norm(here[:, None] - (here * sign)[None], axis=2)
        assert distance.min(axis=1).max() < 1e-12


def test_fiber_names_are_unique(letter: Character) -> None:
    names = [fiber.name for fiber in letter.fibers]
    assert len(set(names)) == len(names)


def test_regions_are_not_empty(letter: Character) -> None:
    assert letter.regions
    assert all(len(nodes) for nodes in letter.regions.values())


def test_made_twice_is_the_same(letter: Character) -> None:
    again = characters.make(letter.name)
    np.testing.assert_array_equal(again.mesh.points, letter.mesh.points)
    np.testing.assert_array_equal(again.mesh.tets, letter.mesh.tets)
    assert {name: nodes.tolist() for name, nodes in again.regions.items()} == {
        name: nodes.tolist() for name, nodes in letter.regions.items()
    }
    for mine, other in zip(letter.fibers, again.fibers, strict=True):
        np.testing.assert_array_equal(mine.vertices, other.vertices)
