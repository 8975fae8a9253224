"""Coarser meshes of the letters are the same bodies with the same parts."""

from __future__ import annotations

import pytest

from warp_softbody import characters, scenes
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.characters.coarser_meshes import LONGER_EDGES
from warp_softbody.errors import InputError

MESHES = [(name, n + 1) for name, edges in LONGER_EDGES.items() for n in range(len(edges))]


@pytest.mark.parametrize(("name", "coarse"), MESHES)
def test_the_same_body_in_fewer_tets(name: str, coarse: int) -> None:
    make = getattr(characters, name)
    usual, finer, coarser = make(), make(coarse=coarse - 1), make(coarse=coarse)
    assert len(coarser.mesh.tets) < 0.8 * len(finer.mesh.tets)
    assert coarser.mesh.volume == pytest.approx(usual.mesh.volume, rel=1e-7)
    assert coarser.mesh.smallest_dihedral_angle > (4.0 if name == "letter_x" else 12.0)
    assert coarser.segment_count == usual.segment_count
    assert set(coarser.regions) == set(usual.regions)
    assert all(len(nodes) for nodes in coarser.regions.values())


def test_none_is_coarser_than_the_coarsest() -> None:
    with pytest.raises(InputError, match="coarse of letter_o must be a whole number from 0 to 1"):
        characters.letter_o(coarse=2)
    with pytest.raises(InputError, match="'coarse' must be a whole number from 0 to 2"):
        scenes.make("balance-i", {"coarse": "3"})


def test_charts_name_them_by_levels_below_zero() -> None:
    settings = Settings(time_step=1.0 / 60.0, level=-1)
    assert (settings.coarse, settings.refinements) == (1, 0)
    plan = settings.plan("slide-f", {})
    assert plan.settings["coarse"] == 1
    assert len(plan.scene.character.mesh.tets) == len(characters.letter_f(coarse=1).mesh.tets)
    finer = Settings(time_step=1.0 / 60.0, level=1)
    assert (finer.coarse, finer.refinements) == (None, 1)
