"""The tables of the page, from charts' files made up, and from those that are stored."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.charts.command import (
    BEGIN,
    END,
    close,
    controlled,
    knobs,
    main,
    passive,
    stored,
    tuned,
)
from warp_softbody.accuracy.analysis.store import SHIPPED, load

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "frontier.md"
NAMES = ("passive", "controlled", "knobs", "close", "stored")


def point(differs: str, cost: float, error: str, **more: str) -> dict[str, str]:
    return {
        "solver": "ours",
        "differs": differs,
        "cost_ms": str(cost),
        "error": error,
        "tets": "654",
        **more,
    }


def write(folder: Path, scene: str, points: list[dict[str, str]], **note: Any) -> None:
    """The files of a chart, whose first point is the default and whose first three are best."""
    lines = [",".join(points[0]), *(",".join(f'"{v}"' for v in one.values()) for one in points)]
    (folder / f"{scene}.csv").write_text("\n".join(lines))
    reference = {"mesh_change": 0.04, "time_change": 0.0123, "mixed_change": 0.0}
    reference["uncertainty"] = sum(reference.values())
    chart = {
        "given": {},
        "seconds": 3.5,
        "default": {**points[0], "gone": "1.4808"},
        "frontier": sorted(points[:3], key=lambda one: float(one["cost_ms"])),
        "functionals": {"gone": {"text": "way", "unit": "m"}},
        "reference": {**reference, "functionals": {"gone": 1.52345}},
    }
    (folder / f"{scene}.json").write_text(json.dumps({**chart, **note}))


@pytest.fixture
def charts(tmp_path: Path) -> Path:
    points = [
        point("default", 400.0, "0.028"),
        point("dt 1/30 s", 200.0, "0.05"),
        point("dt 1/120 s, tolerance 0.01", 700.0, "0.0051"),
        point("QPs 1", 500.0, "0.9"),
        point("Newton 2", 600.0, ""),
        {**point("smoothed", 0.0, ""), "tets": "0"},
        {**point("float64", 1.0, "0.1"), "solver": "MuJoCo flex"},
    ]
    write(tmp_path, "slide-f", points)
    write(tmp_path, "stack", points[:3], given={"count": 2.0})
    return tmp_path


def test_rows_of_both_kinds(charts: Path) -> None:
    found = stored(charts)
    assert list(found) == ["stack", "slide-f"]
    (row,) = passive(found).splitlines()[2:]
    assert row == (
        "| `stack`, count=2 | 3.5 | way 1.523 m | 5.2 % (4 %, 1.2 %, 0 %) | 400 ms, 2.8 % | "
        "400 ms: default | 700 ms, 0.51 %: dt 1/120 s, tolerance 0.01 |"
    )
    row, _, picture = controlled(found).splitlines()[2:]
    assert row == (
        "| `slide-f` | 3.5 | way 1.48, 1.52 m | 5.2 % (4 %, 1.2 %) | 400 ms, 2.8 % | "
        "200 ms, 5 %: dt 1/30 s; 400 ms, 2.8 %: default; "
        "700 ms, 0.51 %: dt 1/120 s, tolerance 0.01 |"
    )
    assert picture == "![slide-f](frontier/slide-f.png)"


def test_single_knobs_are_told_apart(charts: Path) -> None:
    head, _, row, middle = knobs(stored(charts)).splitlines()
    assert head == "| scene | as shipped | Newton 2 | QPs 1 | dt 1/30 s | smoothed |"
    assert row == "| `slide-f` | 2.8 | fails | 90 | 5 | refused |"
    assert middle.endswith("median | 1.00 |  | 1.25 | 0.50 |  |")


def test_the_cheapest_sound_point_within_five_percent(charts: Path) -> None:
    (row,) = close(stored(charts)).splitlines()[2:]
    assert row == "| `slide-f` | 2.8 % | dt 1/30 s: 5 % | 2.5, 5 | 2.0 |"
    shaky = [point("default", 400.0, "0.028", reversals="0.05", volume="0.02")]
    shaky.append(point("dt 1/30 s", 200.0, "0.05", reversals="0.12", volume="0.02"))
    shaky.append(point("float64", 300.0, "0.01", reversals="0.02", volume="0.02"))
    shaky[2]["precision"] = "float64"
    shaky[0]["precision"] = shaky[1]["precision"] = "float32"
    write(charts, "slide-f", shaky)
    assert "| default: 2.8 % | 2.5, 2.5 | 1.0 |" in close(stored(charts))
    write(charts, "slide-f", [point("default", 400.0, "0.08")])
    assert "| 8 % | none |  |  |" in close(stored(charts))


def test_stored_settings_are_all_told() -> None:
    rows = tuned().splitlines()[2:]
    assert len(rows) == len(load(SHIPPED))
    assert all(f"`{one.scene}`" in row for one, row in zip(load(SHIPPED), rows, strict=True))


def test_tables_go_between_the_marks_of_the_page(charts: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    command = ["--charts", str(charts), "--write", str(page)]
    main(command)
    once = page.read_text(encoding="utf-8")
    main(command)
    assert page.read_text(encoding="utf-8") == once
    assert "| `slide-f` | 2.8 | fails |" in once
    for name in NAMES:
        assert once.count(BEGIN.format(name)) == 1
    assert once.count(END) == len(NAMES)
    page.write_text("nothing")
    with pytest.raises(ValueError, match="no lines"):
        main(command)
