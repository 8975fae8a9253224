"""The command on one short run, and what the table shows of outcomes made up."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.motions.criteria import CRITERIA
from benchmarks.motions.measures import lifts, slip
from benchmarks.robustness.command import main
from benchmarks.robustness.other_meshes import make_meshes
from benchmarks.robustness.outcomes import VariationOutcome
from benchmarks.robustness.table import BEGIN, END, markdown
from benchmarks.robustness.variations import EDGES, VARIATIONS
from warp_softbody import scenes
from warp_softbody.accuracy.cases.body_motion import spans


def outcome(variation: str, own: str, *failures: str, volume: float = 0.01) -> VariationOutcome:
    values = {"volume": volume, "reversals": 0.1}
    return VariationOutcome(
        scene="slide-f", variation=variation, own=own, failures=failures, values=values
    )


def test_every_controlled_scene_has_criteria() -> None:
    controlled = {name for name in scenes.names() if scenes.make(name).controller is not None}
    assert set(CRITERIA) == controlled


def test_a_variation_changes_what_it_says_and_nothing_else(tmp_path: Path) -> None:
    shipped = VARIATIONS["as shipped"].plan("slide-f", tmp_path)
    floor = VARIATIONS["friction -20 %"].plan("slide-f", tmp_path)
    soft = VARIATIONS["stiffness -20 %"].plan("slide-f", tmp_path)
    half = VARIATIONS["half the step"].plan("slide-f", tmp_path)
    assert floor.scene.ground is not None and shipped.scene.ground is not None
    assert floor.scene.ground.friction == pytest.approx(0.8 * shipped.scene.ground.friction)
    moduli = [plan.scene.character.material.young_modulus for plan in (soft, shipped, floor)]
    assert moduli == pytest.approx([0.8 * moduli[1], moduli[1], moduli[1]])
    assert half.time_step == 0.5 * shipped.time_step == 0.5 * soft.time_step


def test_another_mesh_is_of_the_same_letter(tmp_path: Path) -> None:
    """Letters are made by TetGen, which the extra `tetgen` brings."""
    pytest.importorskip("tetgen")
    make_meshes(tmp_path, EDGES, ["letter_f"])
    shipped = VARIATIONS["as shipped"].plan("slide-f", tmp_path).scene.character
    other = VARIATIONS["other mesh"].plan("slide-f", tmp_path).scene.character
    assert len(other.mesh.tets) != len(shipped.mesh.tets)
    # the surface is that of the same outline
    assert other.mesh.volume == pytest.approx(shipped.mesh.volume, rel=1e-9)
    assert set(other.regions) == set(shipped.regions)
    assert len(scenes.make("slide-f").scene.character.mesh.tets) == len(shipped.mesh.tets)


def test_a_run_is_printed_kept_and_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page, journal = tmp_path / "page.md", tmp_path / "runs.jsonl"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    arguments = ["walk-x", "--variations", "as shipped", "--seconds", "0.1"]
    arguments += ["--journal", str(journal), "--write", str(page)]
    main(arguments)
    # in a tenth of a second it has not gone its length
    assert capsys.readouterr().out.startswith("walk-x            as shipped      **")
    kept = json.loads(journal.read_text())
    assert abs(kept["values"]["ahead"]) < 0.1
    assert kept["values"]["volume"] < 0.05
    text = page.read_text()
    assert text.startswith("before") and text.endswith("after\n") and "| `walk-x` |" in text
    main(arguments)
    assert len(journal.read_text().splitlines()) == 1


def test_the_table_says_what_fails_and_the_worst() -> None:
    found = {
        ("slide-f", "as shipped"): outcome("as shipped", "2.00 m"),
        ("slide-f", "other mesh"): outcome(
            "other mesh", "0.50 m", "slides 0.50 m", "volume 6.0%", volume=0.06
        ),
    }
    line = markdown(found, ["slide-f"], list(VARIATIONS)[:3]).splitlines()[-1]
    cells = [cell.strip() for cell in line.split("|")[1:-1]]
    assert cells[:2] == ["`slide-f`", "slides >= 1.00 m"]
    assert cells[2:] == ["2.00 m", "**0.50 m**, **volume 6.0%**", "", "6.0%", "10.0%"]


def test_spans_lifts_and_slip() -> None:
    heights = np.array([0.0, 2.0, 3.0, 0.0, 1.5, 0.0, 4.0])
    assert spans(heights > 1.0) == [(1, 3), (4, 5), (6, 7)]
    # the last one is still up
    assert lifts(heights, 1.0) == [3.0, 1.5]
    assert slip(np.array([0.0, 1.0, 0.8, 2.0])) == pytest.approx(0.1)
    assert slip(np.array([0.0, -1.0])) == np.inf
