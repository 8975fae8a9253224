"""`chart`, `tune` and `run --error` on a case of half a second's work."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.accuracy.inline import Inline
from warp_softbody.accuracy.analysis import store
from warp_softbody.accuracy.cases import functionals, table
from warp_softbody.accuracy.cases.case import TIME_STEPS
from warp_softbody.accuracy.cases.functionals import Functional
from warp_softbody.accuracy.cases.track import Track
from warp_softbody.cli import chart_command, main, tune_command
from warp_softbody.inputs import extras

TINY = replace(
    table.CASES["cantilever"],
    seconds=0.2,
    meshes=((1, 0), (2, 0), (None, 0)),
    time_steps=TIME_STEPS[:3],
    knobs={"elements": ("smoothed",), "tolerance": (1e-2, 1e-3), "threads": (2,)},
    finest=((2, 1), TIME_STEPS[2]),
    beside=((2, 0), TIME_STEPS[4]),
    peers=(),
    products=4,
)


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Inline]:
    """The tiny case in place of the real one, run here; the executors that were asked for."""
    made: list[Inline] = []

    @contextmanager
    def inline(args: object) -> Iterator[Inline]:
        made.append(Inline())
        yield made[-1]

    monkeypatch.setitem(table.CASES, "cantilever", TINY)
    monkeypatch.setattr(chart_command, "sweep_workers", inline)
    monkeypatch.setattr(tune_command, "sweep_workers", inline)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setattr(store, "SHIPPED", tmp_path / "shipped.json")
    return made


@pytest.fixture(scope="module")
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of all tests here, so that the runs are made once."""
    return tmp_path_factory.mktemp("journal")


def answer(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = main([str(argument) for argument in arguments])
    return (code, *capsys.readouterr())


def test_chart_writes_table_reference_and_picture(
    runs: list[Inline], journal: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    where = ("--out", tmp_path, "--journal", journal)
    code, out, err = answer(capsys, "chart", "cantilever", *where)
    assert (code, err) == (0, "")
    assert "the coarser mesh differs by" in out and "twice the least time step by" in out
    rows = list(csv.DictReader((tmp_path / "cantilever.csv").read_text().splitlines()))
    assert {row["status"] for row in rows} == {"complete"}
    note: dict[str, Any] = json.loads((tmp_path / "cantilever.json").read_text())
    assert len(rows) == note["points"] > 15
    changes = [note["reference"][f"{kind}_change"] for kind in ("mesh", "time", "mixed")]
    assert note["reference"]["uncertainty"] == pytest.approx(sum(changes))
    frontier = [row for row in rows if row["frontier"] == "1"]
    assert 1 <= len(frontier) == len(note["frontier"])
    costs = [float(row["cost_ms"]) for row in frontier]
    errors = [float(row["error"]) for row in frontier]
    assert costs == sorted(costs) and errors == sorted(errors, reverse=True)
    assert (tmp_path / "cantilever.png").read_bytes()[:4] == b"\x89PNG"
    assert (tmp_path / "cantilever.png").stat().st_size < 80_000
    # threads change no number
    plain = {"time_step": "0.008333", "cells": "", "level": "0", "elements": "linear"}
    alike = [
        row
        for row in rows
        if row["tolerance"] == "" and all(row[knob] == value for knob, value in plain.items())
    ]
    assert sorted(row["threads"] for row in alike) == ["1", "2"]
    assert len({(row["error"], row["tip_fall"]) for row in alike}) == 1
    # from the journal, nothing is run again
    code, out, _ = answer(capsys, "chart", "cantilever", *where, "--json")
    assert (code, runs[0].calls >= 15, runs[1].calls) == (0, True, 0)
    (told,) = json.loads(out)["charts"]
    assert told["reference"] == note["reference"]


def test_tune_stores_what_run_uses(
    runs: list[Inline], journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = answer(capsys, "run", "cantilever", "--error", "60%")
    assert (code, out) == (
        2,
        "",
    ) and "no stored settings of 'cantilever' for an error of 60%" in err
    code, out, err = answer(
        capsys, "tune", "cantilever", "--error", "60%", "--journal", journal, "--json"
    )
    tuned: dict[str, Any] = json.loads(out)
    assert (code, err, tuned["bound"]) == (0, "", 0.6)
    # the bound is wide enough for the cheapest point of all
    assert tuned["error"] + tuned["uncertainty"] <= 0.8 * 0.6
    assert Path(tuned["stored"]) == store.own_file()
    short = ("--seconds", 0.1, "--json")
    code, out, err = answer(capsys, "run", "cantilever", "--error", "0.7", *short)
    ran: dict[str, Any] = json.loads(out)
    assert (code, err, ran["tuned"]["bound"]) == (0, "", 0.6)
    settings = tuned["settings"]
    assert ran["time_step"] == pytest.approx(settings["time_step"])
    assert (ran["elements"], ran["precision"]) == (settings["elements"], settings["precision"])
    assert ran["settings"]["cells"] == (settings["cells"] or 3)
    # what is given stays
    code, out, _ = answer(
        capsys,
        "run",
        "cantilever",
        "--error",
        0.7,
        *short,
        "--time-step",
        1 / 240,
        "--set",
        "cells=1",
    )
    ran = json.loads(out)
    assert ran["time_step"] == pytest.approx(1 / 240) and ran["tets"] == 30
    # a tighter bound is not what was stored
    code, _, err = answer(capsys, "run", "cantilever", "--error", "50%")
    assert code == 2 and "(stored: 60%)" in err


def test_tune_says_what_it_left_out_and_what_cannot_be_held(
    runs: list[Inline], journal: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    where = ("--journal", journal, "--out", tmp_path / "mine.json")
    code, out, _ = answer(capsys, "tune", "cantilever", "--error", "60%", *where)
    assert code == 0 and "left out" in out and "within 80 % of the bound of 60 %" in out
    answer(capsys, "tune", "cantilever", "--error", "90%", *where)
    kept = store.load(tmp_path / "mine.json")
    assert [tuned.bound for tuned in kept] == [0.6, 0.9]
    code, _, err = answer(capsys, "tune", "cantilever", "--error", "0.0001%", *where)
    assert code == 2 and "the least bound that can be held is" in err


def test_settings_of_the_scene_are_tried_and_found_again(
    runs: list[Inline], journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Soft, by a few runs of it; the plain scene's settings are for another one."""
    soft = ("--set", "young_modulus=5e5")
    tune = ("tune", "cantilever", "--journal", journal, "--error", "40%")
    code, out, err = answer(capsys, *tune, *soft, "--json")
    tuned: dict[str, Any] = json.loads(out)
    assert (code, err, tuned["given"]) == (0, "", {"young_modulus": 5e5})
    assert tuned["error"] + tuned["uncertainty"] <= 0.4
    run = ("run", "cantilever", "--error", "40%", "--seconds", 0.1, "--json")
    code, out, _ = answer(capsys, *run, *soft)
    ran: dict[str, Any] = json.loads(out)
    assert (code, ran["tuned"]["settings"]) == (0, tuned["settings"])
    code, _, err = answer(capsys, *run)
    assert code == 2 and "no stored settings" in err
    answer(capsys, *tune)
    stiff = ("--set", "young_modulus=2e6")
    code, _, err = answer(capsys, *run[:-1], *stiff)
    assert code == 0 and "--set young_modulus=2e+06` tries these settings" in err
    code, _, err = answer(capsys, *tune, "--set", "cells=2")
    assert code == 2 and "cells is what tune chooses" in err


def test_shipped_settings_are_found_and_own_ones_come_first(
    runs: list[Inline], journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tune = ("tune", "cantilever", "--journal", journal, "--error")
    answer(capsys, *tune, "60%", "--out", store.SHIPPED)
    shipped = store.find("cantilever", 0.6)
    store.save(replace(shipped, cost=1e-3), store.own_file())
    assert store.find("cantilever", 0.6).cost == 1e-3


def test_all_goes_on_where_a_scene_fails(
    runs: list[Inline],
    journal: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first one has a functional that raises; the second one's files are written."""
    pytest.importorskip("matplotlib")

    def broken(track: Track) -> float:
        raise ValueError("no such thing")

    wrong = Functional(unit="m", text="what cannot be measured", of=broken)
    monkeypatch.setitem(functionals.FUNCTIONALS, "wrong", wrong)
    other = replace(TINY, scene="twisted-bar", functionals=("wrong",))
    monkeypatch.setattr(table, "CASES", {"twisted-bar": other, "cantilever": TINY})
    where = ("--out", tmp_path, "--journal", journal)
    code, out, err = answer(capsys, "chart", "all", *where)
    assert code == 2
    assert "no chart of twisted-bar: ValueError: no such thing" in err
    assert err.rstrip().endswith("failed: twisted-bar")
    assert out.startswith("cantilever: ") and (tmp_path / "cantilever.csv").exists()
    assert not (tmp_path / "twisted-bar.csv").exists()
    code, out, err = answer(capsys, "chart", "all", *where, "--json")
    told = json.loads(out)
    assert (code, told["failed"], [one["scene"] for one in told["charts"]]) == (
        2,
        ["twisted-bar"],
        ["cantilever"],
    )
    # nothing that was finished is run again
    assert runs[-1].calls == 0
    # where it is the only one, it is not hidden
    with pytest.raises(ValueError, match="no such thing"):
        answer(capsys, "chart", "twisted-bar", *where)


def test_mistakes_are_one_sentence(
    runs: list[Inline], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for arguments, sentence in (
        (("chart", "cantilevr"), "did you mean 'cantilever'?"),
        (("chart", "stairs"), "scene 'stairs' has no chart; charted are: cantilever, "),
        (("tune", "cantilever", "--error", "much"), "must be a share of 1, such as 2% or 0.02"),
        (("tune", "cantilever", "--error", "200%"), "at most 100%, got '200%'"),
    ):
        code, out, err = answer(capsys, *arguments)
        assert (code, out, err.count("\n")) == (2, "", 1) and sentence in err
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    code, _, err = answer(capsys, "chart", "cantilever")
    assert code == 2 and "pip install 'warp-softbody[charts]'" in err


def test_every_row_of_the_table_can_be_run() -> None:
    """Its scene, its settings, its functionals, and a reference finer than its default."""
    from warp_softbody import scenes
    from warp_softbody.accuracy.analysis.design import first_points
    from warp_softbody.accuracy.cases.functionals import FUNCTIONALS

    for case in table.CASES.values():
        plan = scenes.make(case.scene, case.given)
        assert (plan.controller is not None) == case.controlled
        assert all(name in FUNCTIONALS for name in case.functionals)
        for chosen in (case, case.quickly()):
            points = first_points(chosen)
            assert chosen.default in points and all(point.possible for point in points)
            assert chosen.finest[0][1] >= chosen.beside[0][1]
            assert chosen.beside[1] <= chosen.finest[1] < chosen.default.time_step * 1.01
