"""Meshes of the letters with longer or shorter edges than the shipped ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

from warp_softbody.characters import store
from warp_softbody.characters.store_mesh import DRAWINGS

OTHER_EDGES = {(1.06, "letter_x"): 0.93, (1.3, "letter_h"): 1.32, (1.3, "letter_x"): 1.35}
"""In place of a factor that leaves a letter dihedral angles below 9 degrees; the coarse letter X
has none that does not, so this is its best."""


def folder_of(meshes: Path, edges: float) -> Path:
    """Where the meshes with edges so many times as long lie."""
    return meshes / f"{edges:g}"


def make_meshes(meshes: Path, edges: float, letters: Iterable[str] = tuple(DRAWINGS)) -> None:
    """Mesh the outlines of letters anew, with edges ``edges`` times as long.

    Raises:
        MissingExtraError: TetGen is not installed.
    """
    for name in letters:
        recipe = DRAWINGS[name]
        size = recipe.size * OTHER_EDGES.get((edges, name), edges)
        store.save(*replace(recipe, size=size).make(), folder_of(meshes, edges))


@contextmanager
def meshes_of(meshes: Path, edges: float) -> Iterator[None]:
    """Characters that are made meanwhile get such meshes; the shipped ones with a factor of 1."""
    if edges == 1.0:
        yield
        return
    with patch.object(store, "DATA", folder_of(meshes, edges)):
        yield
