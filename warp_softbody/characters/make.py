"""Make a stored mesh again from its recipe.

`python -m warp_softbody.characters.make NAME -o FOLDER` writes `NAME.npz` and `NAME.json`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from warp_softbody.characters.store import load_recipe, save
from warp_softbody.errors import SoftBodyError


def main(arguments: Sequence[str] | None = None) -> int:
    """Make one mesh; return 0, or 2 after one sentence on what went wrong."""
    parser = argparse.ArgumentParser(prog="python -m warp_softbody.characters.make")
    parser.add_argument("name", help="character, such as letter_i")
    parser.add_argument("-o", "--output", type=Path, default=Path("."), help="folder to write to")
    options = parser.parse_args(arguments)
    try:
        mesh, recipe = load_recipe(options.name).make()
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
