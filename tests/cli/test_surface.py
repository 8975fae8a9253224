"""Listing, help, versions, and what is shown on a terminal."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import pytest

from warp_softbody import __version__, scenes
from warp_softbody.cli.progress import ProgressBar


def test_list_names_scenes_and_settings(call: Any) -> None:
    answer = call("list")
    assert answer.code == 0
    for name in scenes.names():
        recipe = scenes.recipe(name)
        assert f"{name} " in answer.out and recipe.description in answer.out
        assert all(f"{setting.name}=" in answer.out for setting in recipe.settings)


def test_list_as_json(call: Any) -> None:
    listed = json.loads(call("list", "--json").out)["scenes"]
    assert [scene["name"] for scene in listed] == list(scenes.names())
    push = listed[0]["settings"][0]
    assert (push["name"], push["default"], push["unit"]) == ("push", 0.5, "body weights")


def test_version_and_help(call: Any) -> None:
    assert call("--version").out == f"warp-softbody {__version__}\n"
    answer = call("run", "--help")
    assert answer.code == 0 and "--time-step" in answer.out


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; from warp_softbody.cli import main; main(['--help'])\n"
        "heavy = ('warp', 'pxr', 'numpy', 'scipy', 'rich')\n"
        "print([name for name in heavy if name in sys.modules], file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        check=True,
    )
    assert done.stderr.strip() == "[]"


def test_progress_is_for_terminals_only(
    call: Any, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    answer = call("run", "topple-i", "--seconds", 0.1, "--json")
    assert json.loads(answer.out)["frames"] == 4
    assert "of 0.1 s" in answer.err
    with ProgressBar("name", 1.0, quiet=False) as progress:
        progress.compiling()
    assert "compiling kernels (first run only)" in capfd.readouterr().err
    assert call("run", "topple-i", "--seconds", 0.1, "--quiet").err == ""
