"""The benchmark of batches runs and tells of every row."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import batches


def test_a_row_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    batches.main(["--rows", "passive", "--members", "2", "--steps", "6"])
    titles, row = capsys.readouterr().out.splitlines()
    assert titles.split()[:3] == ["row", "members", "single"]
    assert row.split()[:2] == ["passive", "2"]
    assert all(float(number) > 0.0 for number in row.split()[2:6])


def test_the_table_goes_into_a_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"before\n{batches.BEGIN}\nold\n{batches.END}\nafter\n")
    asked = ["--rows", "passive", "--members", "3", "--steps", "6", "--write", str(page)]
    batches.main(asked)
    before, *table, after = page.read_text().split("\n\n")
    assert before.startswith("before") and after.endswith("after\n")
    lines = "\n".join(table).splitlines()
    assert [line.split(" | ")[1] for line in lines[2:]] == ["3"]
