"""The command: what it prints and writes, and what it refuses."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from benchmarks.stability import table as stability_table
from benchmarks.stability.command import main
from benchmarks.stability.mujoco_cases import missing
from benchmarks.stability.outcomes import CONFIGURATIONS, StabilityOutcome, everything
from benchmarks.stability.peers import MEASURED, MUJOCO, PEERS, TIME_STEPS
from benchmarks.stability.runs import Run

PAGE = Path(__file__).parents[2] / "docs" / "stability.md"
NAMES = [row.name for row in everything()]


def outcomes() -> list[StabilityOutcome]:
    return [
        StabilityOutcome(
            case=name, configuration=configuration, verdict=f"{name} fares well", failures={}
        )
        for name in NAMES
        for configuration in CONFIGURATIONS
    ]


def test_prints_a_line_for_each_case_and_configuration(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--cases", "dt 0.1, NaN state"])
    lines = capsys.readouterr().out.splitlines()
    count = len(CONFIGURATIONS)
    expected = ["dt 0.1"] * count + ["NaN state"] * count
    assert [line.split("  ")[0].strip() for line in lines] == expected
    assert lines[0].endswith("recovers")


def test_prints_json(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--cases", "dt 0.1", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert [one["configuration"] for one in found] == list(CONFIGURATIONS)
    assert found[0]["runs"][0]["volume"] == pytest.approx(1.0, abs=0.01)
    assert found[0]["failures"] == {}


def test_json_has_null_for_what_a_stopped_run_did_not_come_to() -> None:
    stopped = StabilityOutcome(
        case="a", configuration="b", verdict="stops", failures={}, runs=(Run(stopped=3),)
    )
    (one,) = json.loads(json.dumps(stopped.to_dict(), allow_nan=False))["runs"]
    assert one["stopped"] == 3
    assert one["volume"] is None


def test_runs_mujoco_beside_ours(capsys: pytest.CaptureFixture[str]) -> None:
    if problem := missing():
        pytest.skip(problem)
    main(["--cases", "dt 0.1,NaN state", "--peers", "--json"])
    found = json.loads(capsys.readouterr().out)
    peer = [one for one in found if one["configuration"] == MUJOCO]
    assert [one["case"] for one in peer] == ["dt 0.1"]
    assert peer[0]["runs"][0]["volume"] == pytest.approx(1.0, abs=0.01)


def test_says_how_to_get_mujoco(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(SystemExit):
        main(["--cases", "dt 0.1", "--peers"])
    assert "warp-softbody[bench]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--cases", "perpetual motion"], "perpetual motion"),
        (["--cases", "dt 0.1", "--write", str(PAGE)], "--write wants all cases"),
        (["--write", "nowhere.md"], "nowhere.md"),
    ],
)
def test_mistakes_are_refused(
    arguments: list[str], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(arguments)
    assert named in capsys.readouterr().err


def test_only_what_stands_between_the_marks_is_written(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    begin, end = stability_table.BEGIN, stability_table.END
    page.write_text(f"# Above\n\n{begin}\nold\n{end}\n\nBelow\n", encoding="utf-8")
    stability_table.write(page, outcomes())
    written = page.read_text(encoding="utf-8")
    assert written.startswith(f"# Above\n\n{begin}\n") and written.endswith(f"{end}\n\nBelow\n")
    assert "old" not in written
    assert all(f"{name} fares well" in written for name in NAMES)
    with pytest.raises(ValueError, match="no lines"):
        stability_table.replaced("no marks", "table")


def test_names_are_unique_and_peers_are_of_rows_that_there_are() -> None:
    assert len(set(NAMES)) == len(NAMES)
    assert set(MEASURED) | set(TIME_STEPS) <= set(NAMES)
    assert all(len(results) == len(PEERS) for results in MEASURED.values())


def test_the_page_has_every_row() -> None:
    page = PAGE.read_text(encoding="utf-8")
    missing = [name for name in NAMES if f"| {name} |" not in page]
    assert not missing, "python -m benchmarks.stability --write docs/stability.md"
