"""The table of speed: its rows, programs in turn, ratios, and the page that it is written into."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.speed import command
from benchmarks.speed.command import ROWS, main
from benchmarks.speed.processes import HERE, time_in_turn
from benchmarks.speed.starts import warm
from benchmarks.speed.table import BEGIN, END, Timing, markdown
from benchmarks.speed.works import OURS, Work, works

PAGE = Path(command.__file__).parents[2] / "docs" / "performance.md"


def short(name: str) -> Work:
    return replace(works()[name], skipped=0, steps=3, turn=2)


def test_programs_are_timed_in_turn_and_one_that_fails_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    programs: dict[str, Path | None] = {OURS: None, "again": HERE, "broken": tmp_path}
    (tmp_path / "warp_softbody").mkdir()
    (tmp_path / "warp_softbody" / "__init__.py").write_text("raise ImportError('not this one')\n")
    shown: list[str] = []
    times = time_in_turn(short("beam-810"), programs, shown.append)
    assert set(times) == {OURS, "again"} and min(times.values()) > 0.0
    assert "beam-810: step 2 of 3" in shown
    assert "broken failed: ImportError: not this one" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["drop-block-7", "crawl-i", "many-passive"])
def test_each_kind_of_work_takes_steps(name: str) -> None:
    step = works()[name].make(OURS)
    step()


def test_a_start_ends_well() -> None:
    start = warm(HERE, repeats=1)
    assert 0.0 < start.cpu and 0.0 < start.wall


def test_ratios_are_over_this_program_and_peers_over_its_double_precision() -> None:
    times = {OURS: 2.0, "ours float64": 4.0, "MuJoCo": 20.0, "../before": 3.0}
    first = Timing(name="beam-810", about="beam", unit="ms a step", times=times)
    second = Timing(name="walk-x", about="walk", unit="ms a step", times={OURS: 1234.5})
    lines = markdown([first, second]).splitlines()
    assert lines[0] == "| work | unit | time | ours float64 | MuJoCo | ../before |"
    assert lines[2] == "| beam | ms a step | 2 | 2 | 5 | 1.5 |"
    assert lines[3] == "| walk | ms a step | 1234 | - | - | - |"


def test_the_command_writes_its_table_into_a_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command, "works", lambda: {"crawl-i": short("crawl-i")})
    page = tmp_path / "page.md"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    assert main(["--rows", "crawl-i", "--write", str(page)]) == 0
    written = page.read_text()
    assert "| `crawl-i`, controlled | ms a step |" in written and "old" not in written
    assert "| `crawl-i`, controlled | ms a step |" in capsys.readouterr().out
    assert main(["--rows", "crawl-i", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert row["name"] == "crawl-i" and list(row["times"]) == [OURS]


def test_what_is_no_checkout_or_row_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for given in (["--against", os.devnull], ["--rows", "walk-y"]):
        with pytest.raises(SystemExit):
            main(given)
        assert given[1] in capsys.readouterr().err


def test_the_page_has_every_row() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert BEGIN in text and END in text
    assert len(ROWS) == len(set(ROWS)) == len(works()) + 2
