"""Meshes of the letters with longer or shorter edges than the stored ones, of these each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

from warp_softbody.characters import store
from warp_softbody.characters.letter_o import ring_outline
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.store_mesh import RECIPES

OTHER_EDGES: Mapping[tuple[float, str], float] = {
    (1.06, "letter_x"): 0.93,
    (1.06, "letter_f_coarse_1"): 1.04,
    (1.06, "letter_i_flat_coarse_1"): 1.04,
    (1.06, "letter_o_coarse_1"): 1.4,
    (1.06, "letter_t_coarse_1"): 1.04,
    (1.06, "letter_t_coarse_2"): 1.02,
    (1.06, "letter_x_coarse_1"): 0.95,
    (1.3, "letter_h"): 1.32,
    (1.3, "letter_x"): 1.35,
    (1.3, "letter_i_coarse_2"): 1.8,
    (1.3, "letter_o_coarse_1"): 1.6,
    (1.3, "letter_t_coarse_2"): 1.35,
    (1.3, "letter_x_coarse_1"): 1.5,
}
"""In place of a factor that leaves a letter dihedral angles below 9 degrees, or hardly another
mesh: sides of the outline are not joined, so that the longest edges of the coarsest meshes grow and
the others do not. The coarse letter X has none without flat tets but the one of 248."""

FEWER_SIDES = {(1.3, "letter_o_coarse_1"): (7, 4)}
"""Sides of a quarter of the rim and of the hole of letter O, whose 10 and 6 short ones otherwise
hold its edges at 1.05 times those of its coarser mesh."""


def folder_of(meshes: Path, edges: float) -> Path:
    """Where the meshes with edges so many times as long lie."""
    return meshes / f"{edges:g}"


def make_meshes(meshes: Path, edges: float, names: Iterable[str] = tuple(RECIPES)) -> None:
    """Make stored meshes anew, by their names, with edges ``edges`` times as long.

    Raises:
        MissingExtraError: TetGen is not installed.
    """
    for name in names:
        store.save(*other_recipe(name, edges).make(), folder_of(meshes, edges))


def other_recipe(name: str, edges: float) -> Recipe:
    """The recipe of a stored mesh with other edges."""
    recipe, key = RECIPES[name], (edges, name)
    if sides := FEWER_SIDES.get(key):
        recipe = replace(recipe, outline=ring_outline(*sides))
    return replace(recipe, size=recipe.size * OTHER_EDGES.get(key, edges))


@contextmanager
def meshes_of(meshes: Path, edges: float) -> Iterator[None]:
    """Characters that are made meanwhile get such meshes; the shipped ones with a factor of 1."""
    if edges == 1.0:
        yield
        return
    with patch.object(store, "DATA", folder_of(meshes, edges)):
        yield
