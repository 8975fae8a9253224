"""A demo that anybody can start."""

from __future__ import annotations

from pathlib import Path

import pytest

from warp_softbody.cli import demo_command, main


def test_a_demo_makes_a_page_and_a_movie(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(demo_command, "SECONDS", 0.1)
    assert main(["demo", str(tmp_path / "shown")]) == 0
    assert "demo.html in a browser" in capsys.readouterr().out
    assert (tmp_path / "shown" / "demo.html").read_text().lstrip().lower().startswith("<!doctype")
    assert (tmp_path / "shown" / "demo.gif").read_bytes().startswith(b"GIF8")


def test_a_folder_that_cannot_be(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert main(["demo", str(tmp_path / "file" / "demo")]) == 2
    assert "cannot be made" in capsys.readouterr().err
