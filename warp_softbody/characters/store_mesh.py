"""Make a mesh from the drawing of its letter, to be stored in the package's data.

`python -m warp_softbody.characters.store_mesh NAME -o FOLDER` writes `NAME.npz` and `NAME.json`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from warp_softbody.characters.coarser_meshes import coarser
from warp_softbody.characters.letter_f import RECIPE as LETTER_F
from warp_softbody.characters.letter_h import RECIPE as LETTER_H
from warp_softbody.characters.letter_i import RECIPE as LETTER_I
from warp_softbody.characters.letter_i_flat import RECIPE as LETTER_I_FLAT
from warp_softbody.characters.letter_o import RECIPE as LETTER_O
from warp_softbody.characters.letter_t import RECIPE as LETTER_T
from warp_softbody.characters.letter_x import RECIPE as LETTER_X
from warp_softbody.characters.letter_x_upright import RECIPE as LETTER_X_UPRIGHT
from warp_softbody.characters.store import save
from warp_softbody.errors import InputError, SoftBodyError

DRAWINGS = {
    recipe.name: recipe
    for recipe in (
        *(LETTER_F, LETTER_H, LETTER_I, LETTER_I_FLAT),
        *(LETTER_O, LETTER_T, LETTER_X, LETTER_X_UPRIGHT),
    )
}
"""Of the meshes that letters have where nothing is said."""

RECIPES = {
    recipe.name: recipe for drawing in DRAWINGS.values() for recipe in (drawing, *coarser(drawing))
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Make one mesh; return 0, or 2 after one sentence on what went wrong."""
    parser = argparse.ArgumentParser(prog="python -m warp_softbody.characters.store_mesh")
    parser.add_argument("name", help="mesh, such as letter_i")
    parser.add_argument("-o", "--output", type=Path, default=Path("."), help="folder to write to")
    options = parser.parse_args(arguments)
    try:
        if options.name not in RECIPES:
            known = ", ".join(RECIPES)
            raise InputError(f"there is no drawing {options.name!r}; there are: {known}")
        mesh, recipe = RECIPES[options.name].make()
        save(mesh, recipe, options.output)
    except SoftBodyError as error:
        print(error, file=sys.stderr)
        return 2
    print(
        f"{recipe.name}: {recipe.node_count} nodes, {recipe.tet_count} tets, "
        f"smallest dihedral angle {mesh.smallest_dihedral_angle:.1f} degrees"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
