"""What the pages tell a reader to type exists, and their Python runs."""

from __future__ import annotations

import re
import subprocess
import sys
from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest

from tests.docs.pages import PAGES, ROOT, commands, python_blocks
from warp_softbody import scenes
from warp_softbody.cli import main

WITH_PYTHON = [page for page in PAGES if python_blocks(page.read_text())]
WITH_COMMANDS = [page for page in PAGES if commands(page.read_text())]


@pytest.mark.parametrize("page", WITH_PYTHON, ids=lambda page: page.stem)
def test_python_runs_and_prints_what_the_page_shows(
    page: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Blocks of one page share their names, as a reader would paste them; runs are cut short."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "page"}
    for number, (code, shown) in enumerate(python_blocks(page.read_text())):
        short = re.sub(r"\bseconds=\d+(?:\.\d+)?", "seconds=0.1", code)
        exec(compile(short, f"{page.name}, block {number}", "exec"), names)
        printed = capsys.readouterr().out
        assert not shown or printed == shown


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=lambda page: page.stem)
def test_commands_exist(page: Path, capsys: pytest.CaptureFixture[str]) -> None:
    unknown = []
    for words in commands(page.read_text()):
        match words:
            case ["warp-softbody", name, *rest]:
                known = command_help(name, capsys)
                unknown += unknown_scene(name, rest)
            case ["python", "-m", "warp_softbody", *rest]:
                known = command_help("", capsys)
            case ["python", "-m", module, *rest]:
                known = module_help(module) if any(map(is_flag, rest)) else ""
                unknown += [] if find_spec(module) else [module]
            case ["make", *rest]:
                known = (ROOT / "Makefile").read_text()
                unknown += [word for word in rest if not is_made(word, known)]
            case _:
                unknown += unknown_extras(words[-1])
                continue
        unknown += [f"{words}: {word}" for word in rest if is_flag(word) and word not in known]
    assert unknown == []


def is_flag(word: str) -> bool:
    return re.match(r"--?[a-z]", word) is not None


def command_help(name: str, capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    assert main([*([name] if name else []), "--help"]) == 0, name
    return capsys.readouterr().out


@cache
def module_help(module: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", module, "--help"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


def unknown_scene(command: str, rest: list[str]) -> list[str]:
    """A scene that does not exist, or settings that it does not take; capitals stand for any."""
    if command not in ("run", "chart", "tune") or not rest or rest[0].isupper() or "|" in rest[0]:
        return []
    own = rest[0].endswith((".char", ".toml"))
    if not own and rest[0] not in (*scenes.names(), "all"):
        return rest[:1]
    settings = [after for word, after in pairwise(rest) if word == "--set"]
    recipe = scenes.recipe("balance-i" if own else rest[0])
    known = {setting.name for setting in recipe.settings} if settings else set()
    return [given for given in settings if given.split("=")[0] not in known | {"KEY"}]


def is_made(word: str, makefile: str) -> bool:
    """Whether make knows a target, or a variable that is given a value."""
    name, _, value = word.partition("=")
    pattern = rf"\b{name}\b" if value else rf"^{name}:"
    return re.search(pattern, makefile, re.MULTILINE) is not None


def unknown_extras(requirement: str) -> list[str]:
    project = (ROOT / "pyproject.toml").read_text()
    extras = re.findall(r"\[(.*)\]", requirement)
    wanted = [extra for found in extras for extra in found.split(",")]
    return [extra for extra in wanted if not re.search(rf"^{extra} = \[", project, re.MULTILINE)]
