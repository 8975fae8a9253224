"""Stored meshes come from their recipes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warp_softbody.body.meshing.tetgen_mesher import tetgen_version
from warp_softbody.characters import store, store_mesh
from warp_softbody.errors import InputError


@pytest.mark.parametrize("name", store.names())
def test_recipe_tells_what_is_stored(name: str) -> None:
    mesh, recipe = store.load_mesh(name), store.load_recipe(name)
    assert recipe.name == name
    assert recipe.drawing == store_mesh.RECIPES[name]
    assert (recipe.node_count, recipe.tet_count) == (len(mesh.points), len(mesh.tets))


@pytest.mark.long
@pytest.mark.parametrize("name", store.names())
def test_recipe_makes_the_stored_mesh(name: str, tmp_path: Path) -> None:
    recipe = store.load_recipe(name)
    if tetgen_version() != recipe.tetgen_version:
        pytest.skip(f"stored with TetGen {recipe.tetgen_version}, found {tetgen_version()}")
    assert store_mesh.main([name, "-o", str(tmp_path)]) == 0
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [f"{name}.json", f"{name}.npz"]
    mesh = store.load_mesh(name)
    with np.load(tmp_path / f"{name}.npz") as made:
        np.testing.assert_allclose(made["points"], mesh.points, atol=1e-12)
        np.testing.assert_array_equal(made["tets"], mesh.tets)
    assert (tmp_path / f"{name}.json").read_text() == recipe.to_json()


def test_unknown_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(InputError, match="no stored character 'letter_q'; there are: letter_f"):
        store.load_mesh("letter_q")
    assert store_mesh.main(["letter_q", "-o", str(tmp_path)]) == 2
    assert "letter_q" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
