"""The variants, the table of outcomes made up, and a sweep that is stopped, resumed and limited."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fidelity.command import main
from benchmarks.fidelity.table import BEGIN, END, NOT_RUN, markdown, moved, moves, summary
from benchmarks.fidelity.variants import COARSER, COMPARED, VARIANTS
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.other_meshes import make_meshes
from benchmarks.robustness.outcomes import Cell, OutcomeJournal, VariationOutcome
from benchmarks.robustness.runs import run
from benchmarks.robustness.sweep import fill
from benchmarks.robustness.variation import Variation
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.simulation import Simulation

PAGE = Path(__file__).parents[2] / "docs" / "robustness.md"
SHIPPED = VARIANTS["as shipped"]
SHORT = 0.1  # s


def outcome(variant: str, way: float | None, *failures: str, **more: object) -> VariationOutcome:
    made = VariationOutcome(
        scene="slide-f",
        variation=variant,
        own="-" if way is None else f"{way:.2f} m",
        failures=failures,
        values={} if way is None else {"slides": way},
    )
    return replace(made, **more)  # type: ignore[arg-type]


def by_name(*outcomes: VariationOutcome) -> dict[tuple[str, str], VariationOutcome]:
    return {(one.scene, one.variation): one for one in outcomes}


def test_time_steps_and_iterations_differ_as_their_names_say(tmp_path: Path) -> None:
    shipped = SHIPPED.simulation(SHIPPED.plan("slide-f", tmp_path))
    assert shipped.model.options.newton_iterations == 1
    wanted = {"dt x 2": (2.0, 1), "dt / 2": (0.5, 1), "dt / 4": (0.25, 1)}
    wanted |= {"two iterations": (1.0, 2), "two iterations, dt / 2": (0.5, 2)}
    for name, (factor, iterations) in wanted.items():
        simulation = VARIANTS[name].simulation(VARIANTS[name].plan("slide-f", tmp_path))
        options = simulation.model.options
        assert options.time_step == pytest.approx(factor * shipped.model.options.time_step)
        assert options.newton_iterations == iterations
        assert simulation.model.tet_count == shipped.model.tet_count
        # a stage shows every step, or 60 a second
        assert simulation.fps == pytest.approx(min(60.0, 1.0 / options.time_step))


def test_tangent_and_elements_differ(tmp_path: Path) -> None:
    variant = VARIANTS["warped tangent"]
    simulation = variant.simulation(variant.plan("slide-f", tmp_path))
    assert simulation.model.options.tangent == "warped"
    variant = VARIANTS["linear elements"]
    simulation = variant.simulation(variant.plan("slide-f", tmp_path))
    assert simulation.model.options.elements == "linear"


def test_meshes_differ(tmp_path: Path) -> None:
    """Coarser ones are made by TetGen, which the extra `tetgen` brings."""
    shipped = SHIPPED.plan("slide-f", tmp_path).scene.character.mesh
    for name in ("refined mesh", "refined mesh, dt / 2"):
        assert len(VARIANTS[name].plan("slide-f", tmp_path).scene.character.mesh.tets) == 8 * len(
            shipped.tets
        )
    pytest.importorskip("tetgen")
    make_meshes(tmp_path, COARSER, ["letter_f"])
    coarser = VARIANTS["coarser mesh"].plan("slide-f", tmp_path).scene.character.mesh
    assert len(coarser.tets) < len(shipped.tets)
    assert coarser.volume == pytest.approx(shipped.volume, rel=1e-9)


def test_every_variant_is_another_run_and_dear_ones_come_last() -> None:
    cells = {name: Cell(scene="slide-f", variation=one) for name, one in VARIANTS.items()}
    assert len({cell.key for cell in cells.values()}) == len(VARIANTS)
    assert cells["as shipped"].key != Cell(scene="crawl-i", variation=SHIPPED).key
    order = sorted(cells, key=lambda name: cells[name].cost)
    assert order[0] == "coarser mesh" and order[-1] == "refined mesh, dt / 2"
    # its name is not what a variation is
    assert Cell(scene="slide-f", variation=replace(SHIPPED, name="other")).key == (
        cells["as shipped"].key
    )


def test_a_cell_shows_what_fails_is_refused_or_was_not_run() -> None:
    names = list(VARIANTS)[:6]
    found = by_name(
        outcome(names[0], 2.0),
        outcome(names[1], 0.5, "slides 0.50 m", "volume 6.0%"),
        outcome(names[2], None, refused="body 'letter_f' is too much"),
        outcome(names[3], None, limit=60.0),
        outcome(names[4], None, "breaks off at 0.25 s"),
    )
    text = markdown(found, ["slide-f"], names)
    cells = [cell.strip() for cell in text.splitlines()[2].split("|")[1:-1]]
    assert cells[:4] == [
        "`slide-f`",
        "slides >= 1.00 m",
        "2.00 m",
        "**0.50 m**, **volume 6.0%**",
    ]
    assert cells[4:6] == ["refused (1)", "longer than 60 s"]
    assert cells[6:8] == ["-, **breaks off at 0.25 s**", NOT_RUN]
    assert "1. Refused: the body is too much." in text
    counts = summary(found, ["slide-f"], names)
    assert counts.startswith(
        "1 of 6 cells hold all criteria; 2 fail, 1 are refused, 2 were not run"
    )


def test_how_far_a_number_moves() -> None:
    first, second, third, fourth, _ = COMPARED
    known = [outcome(first, 2.0), outcome(second, 2.2), outcome(third, 1.9, "volume 9.0%")]
    found = by_name(*known, outcome(fourth, None, refused="no"), outcome("dt x 2", 9.0))
    share, count = moved(found, "slide-f") or (0.0, 0)
    assert share == pytest.approx(0.15)
    assert count == 3
    broken = by_name(*known, outcome(fourth, None, "breaks off at 0.25 s"))
    assert moved(broken, "slide-f") == (np.inf, 4)
    assert moves(broken, "slide-f") == "breaks off (4 of 5)"
    assert moves(found, "slide-f") == "15% (3 of 5)"
    assert moved(by_name(known[0]), "slide-f") is None
    assert moved(by_name(*known[1:]), "slide-f") is None
    # of an error, which is to be small, as a share of its bound
    small = {
        ("exercise-h", one.variation): replace(one, scene="exercise-h", values={"error": value})
        for one, value in zip(known, (0.001, 0.002, 0.011), strict=True)
    }
    assert (moved(small, "exercise-h") or (0.0, 0))[0] == pytest.approx(0.1)


def test_a_stopped_sweep_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page, journal = tmp_path / "page.md", tmp_path / "new" / "runs.jsonl"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    given = ["--scenes", "walk-x", "--seconds", str(SHORT), "--journal", str(journal)]
    assert main([*given, "--variants", "as shipped", "--write", str(page)]) == 0
    # in a tenth of a second it has not gone its length
    assert "| `walk-x` | ahead >= 1.00 m | **" in capsys.readouterr().out
    assert "| `walk-x` |" in page.read_text() and page.read_text().endswith("after\n")
    # the line that was being written when the program was ended
    with journal.open("a") as file:
        file.write('{"key": "0123')
    assert main([*given, "--variants", "as shipped", "dt x 2", "--json"]) == 0
    cells = json.loads(capsys.readouterr().out)["cells"]
    assert [cell["variation"] for cell in cells] == ["as shipped", "dt x 2"]
    assert not any(cell["holds"] for cell in cells)
    assert len(journal.read_text().splitlines()) == 3
    again = OutcomeJournal(journal)
    for name in ("as shipped", "dt x 2"):
        assert again.of(Cell(scene="walk-x", variation=VARIANTS[name], seconds=SHORT)) is not None
    # nothing begins without time
    assert main([*given, "--variants", "dt / 4", "--budget", "0"]) == 0
    assert NOT_RUN in capsys.readouterr().out


def test_a_run_that_is_refused_breaks_off_or_takes_too_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def made(variation: Variation, limit: float | None = None) -> VariationOutcome:
        return run(Cell(scene="slide-f", variation=variation, seconds=SHORT), tmp_path, limit)

    impossible = Variation(name="impossible", options={"max_iterations": 0})
    refused = made(impossible)
    assert "max_iterations" in refused.refused and not refused.holds
    assert str(made(SHIPPED, 1e-9)) == "longer than 1e-09 s"

    def break_off(simulation: Simulation) -> None:
        raise NotFiniteError("numbers stopped being finite", step=3, time=0.05)

    monkeypatch.setattr(Simulation, "step", break_off)
    assert str(made(SHIPPED)) == "-, **breaks off at 0.05 s**"


def test_a_run_is_made_again_where_it_is_given_more_time(tmp_path: Path) -> None:
    journal = OutcomeJournal(tmp_path / "runs.jsonl")
    cell = Cell(scene="slide-f", variation=SHIPPED)
    journal.add(cell, outcome("as shipped", None, limit=60.0))
    assert journal.of(cell, 60.0) is not None
    assert journal.of(cell, 61.0) is None and journal.of(cell) is None
    seen: list[VariationOutcome] = []
    fill(journal, [cell], 1, lambda one, *_: seen.append(one), limit=30.0)
    assert not seen


def test_a_budget_that_is_over_with_the_first_run_leaves_the_others() -> None:
    names = ("as shipped", "dt x 2", "dt / 2")
    cells = [Cell(scene="slide-f", variation=VARIANTS[name], seconds=SHORT) for name in names]
    seen: list[str] = []
    # when it begins, before the first run, and after it
    fill(
        OutcomeJournal(None),
        cells,
        1,
        lambda outcome, *_: seen.append(outcome.variation),
        budget=5.0,
        clock=iter((0.0, 1.0, 6.0)).__next__,
    )
    # the cheapest
    assert seen == ["dt x 2"]


def test_ctrl_c_keeps_what_is_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    journal = tmp_path / "runs.jsonl"

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    given = ["--scenes", "slide-f", "--seconds", str(SHORT), "--journal", str(journal)]
    assert main([*given, "--variants", "as shipped", "dt x 2"], show=stop) == 130
    assert str(journal) in capsys.readouterr().err
    assert len(journal.read_text().splitlines()) == 1


def test_the_page_has_every_scene_and_variant() -> None:
    written = PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    head, _, *lines = [line for line in written.splitlines() if line.startswith("|")]
    titles = [cell.strip() for cell in head.split("|")[1:-1]]
    assert titles == ["scene", "number", *VARIANTS, "moves by"]
    assert [line.split("|")[1].strip() for line in lines] == [f"`{name}`" for name in CRITERIA]
    assert all(line.count("|") == head.count("|") for line in lines)
    assert "cells hold all criteria" in written and "Written on" in written


def test_settings_of_a_scene_are_runs_of_their_own(tmp_path: Path) -> None:
    journal = tmp_path / "runs.jsonl"
    line = ["--scenes", "balance-i", "--variants", "as shipped", "--journal", str(journal)]
    for more in ([], ["--set", "push=0.3"]):
        assert main([*line, "--seconds", str(SHORT), *more]) == 0
    assert len(journal.read_text().splitlines()) == 2
    with pytest.raises(SystemExit):
        main([*line, "--set", "push=much"])
