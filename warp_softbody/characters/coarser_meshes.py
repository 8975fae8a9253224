"""Coarser meshes of the letters: the same drawings with longer edges, stored beside the usual ones.

Each is the best of those with about as many tets, by its smallest dihedral angle; letter X has none
above 5 degrees, letter O none with fewer tets, as its rim is drawn in short sides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from warp_softbody.characters.recipe import Recipe
from warp_softbody.inputs import checks

LONGER_EDGES: Mapping[str, tuple[float, ...]] = {
    "letter_f": (1.27, 1.45),
    "letter_h": (1.45, 1.72),
    "letter_i": (1.45, 1.81),
    "letter_i_flat": (1.45, 1.57),
    "letter_o": (1.3,),
    "letter_t": (1.27, 1.45),
    "letter_x": (1.35,),
    "letter_x_upright": (1.3, 1.6),
}
"""Edges over those of the usual mesh, of the first coarser mesh, the second and so on."""


def stored_name(name: str, coarse: float) -> str:
    """Name of a letter's mesh that is so many times coarser; 0 for the usual one.

    Raises:
        InputError: there is no such mesh.
    """
    label = f"coarse of {name}"
    number = checks.whole(label, coarse, low=0, high=len(LONGER_EDGES.get(name, ())))
    return f"{name}_coarse_{number}" if number else name


def coarser(recipe: Recipe) -> list[Recipe]:
    """Recipes of the coarser meshes of a letter."""
    return [
        replace(recipe, name=stored_name(recipe.name, number), size=recipe.size * edges)
        for number, edges in enumerate(LONGER_EDGES[recipe.name], start=1)
    ]
