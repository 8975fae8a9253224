"""The tables of options in docs/command-line.md."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from benchmarks.option_tables import CLASSES, main, table
from warp_softbody.inputs.option_fields import options_of

PAGE = Path(__file__).parents[2] / "docs" / "command-line.md"


def test_the_page_is_up_to_date(tmp_path: Path) -> None:
    copy = tmp_path / PAGE.name
    shutil.copyfile(PAGE, copy)
    assert main(["--write", str(copy)]) == 0
    assert copy.read_text() == PAGE.read_text()


def test_every_option_has_its_row(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    printed = capsys.readouterr().out
    for owner in CLASSES:
        assert table(owner) in printed
        for one in options_of(owner):
            assert f"| `{one.flag_name if one.flag else one.name}`" in printed
            assert one.help in printed
