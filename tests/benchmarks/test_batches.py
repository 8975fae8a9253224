"""The benchmark of batches runs and tells of every row."""

from __future__ import annotations

import pytest

from benchmarks import batches


def test_a_row_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    batches.main(["--rows", "passive", "--members", "2", "--steps", "6"])
    titles, row = capsys.readouterr().out.splitlines()
    assert titles.split()[:3] == ["row", "members", "single"]
    assert row.split()[:2] == ["passive", "2"]
    assert all(float(number) > 0.0 for number in row.split()[2:6])
