"""The shipped meshes are stored as `data/NAME.npz` with their recipe in `data/NAME.json`."""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path

import numpy as np

from warp_softbody.atomic_files import replacing
from warp_softbody.body.mesh import TetMesh
from warp_softbody.characters.coarser_meshes import stored_name
from warp_softbody.characters.recipe import Recipe
from warp_softbody.errors import InputError, OutputError

DATA = files("warp_softbody.characters") / "data"


def names() -> list[str]:
    """Names of the stored meshes."""
    return sorted(Path(entry.name).stem for entry in DATA.iterdir() if entry.name.endswith(".npz"))


def load_mesh(name: str, coarse: int = 0) -> TetMesh:
    """Stored mesh of a character, or one that is coarser (`coarser_meshes.py`).

    Raises:
        InputError: there is no stored mesh of that name, or none so coarse.
    """
    name = stored_name(name, coarse)
    _check_name(name)
    with as_file(DATA / f"{name}.npz") as path, np.load(path) as arrays:
        return TetMesh.from_arrays(arrays["points"], arrays["tets"], source=f"character {name}")


def load_recipe(name: str) -> Recipe:
    """Recipe of a stored mesh.

    Raises:
        InputError: there is no stored mesh of that name.
    """
    _check_name(name)
    return Recipe.from_json((DATA / f"{name}.json").read_text(encoding="utf-8"))


def save(mesh: TetMesh, recipe: Recipe, folder: Path) -> None:
    """Write mesh and recipe into a folder, each in one step.

    Raises:
        OutputError: the folder cannot be written.
    """
    array, text = (folder / f"{recipe.name}.{kind}" for kind in ("npz", "json"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(array) as new_array, replacing(text) as new_text:
            np.savez_compressed(new_array, points=mesh.points, tets=mesh.tets)
            new_text.write_text(recipe.to_json(), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error


def _check_name(name: str) -> None:
    if name not in names():
        raise InputError(f"there is no stored character {name!r}; there are: {', '.join(names())}")
