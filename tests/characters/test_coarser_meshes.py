"""Coarser meshes of the letters are the same bodies with the same parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from warp_softbody import characters, scenes
from warp_softbody.accuracy.analysis.design import job
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.recording import Recording
from warp_softbody.characters.coarser_meshes import LONGER_EDGES
from warp_softbody.errors import InputError
from warp_softbody.scenes import slide_f

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
    assert (finer.coarse, finer.refinements) == (0, 1)


def test_level_0_is_the_usual_mesh_whatever_ships(monkeypatch: pytest.MonkeyPatch) -> None:
    """References, charts and tuned settings name meshes, not how far they are from what ships."""
    usual = Settings(time_step=1.0 / 60.0)
    assert usual.of_scene("slide-f") == {"coarse": 0}
    # a scene without such meshes is not asked for one, unless its settings do
    assert usual.of_scene("cantilever") == {}
    with pytest.raises(InputError, match="no setting 'coarse'"):
        Settings(time_step=0.01, level=-1).plan("cantilever", {})
    assert Settings(time_step=0.01, level=-2, patches=5).of_scene("roll-o") == {
        "coarse": 2,
        "patches": 5,
    }
    for coarse in (0, 1, 2):
        settings = tuple(
            replace(one, default=float(coarse)) if one.name == "coarse" else one
            for one in slide_f.SLIDE_F.settings
        )
        monkeypatch.setattr(slide_f, "SLIDE_F", replace(slide_f.SLIDE_F, settings=settings))
        case = CASES["slide-f"]
        assert case.default.level == -coarse and case.usual.level == 0
        for asked, letter in (
            (case.default, characters.letter_f(coarse=coarse)),
            (case.usual, characters.letter_f()),
            (replace(usual, level=-1), characters.letter_f(coarse=1)),
        ):
            scene = asked.plan("slide-f", {}).scene
            assert len(scene.character.mesh.tets) == len(letter.mesh.tets)
            # all runs of a chart follow the same material points
            count = len(scene.character.mesh.points)
            recording = Recording(job(case, asked), scene, np.ones(count))
            recording.add(0.0, scene.character.mesh.points)
            places = characters.letter_f().mesh.points[::2]
            np.testing.assert_allclose(recording.path()[0], places, atol=1e-6)
