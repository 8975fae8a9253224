"""Every file, module and command that the pages name is there."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path, PurePosixPath

import pytest

from tests.support.import_graph import ROOT, module_files

PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md")), ROOT / "Makefile"]
FILES = module_files()
PLACES = [PurePosixPath(path.relative_to(ROOT)) for path in FILES.values()]
TEXTS = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in PAGES}
SOURCES = {str(p.relative_to(ROOT)): p.read_text(encoding="utf-8") for p in FILES.values()}


def named(pattern: str, texts: dict[str, str]) -> list[tuple[str, str]]:
    """Page and match of everything that fits, each once; NAME stands for any name."""
    found = {(page, match) for page, text in texts.items() for match in re.findall(pattern, text)}
    return sorted((page, match.replace("NAME", "*")) for page, match in found)


def test_files_that_pages_name_are_there() -> None:
    """By their whole path or its end; a star stands for some letters of a name."""
    names = named(r"(?<![\w/*.\-])[\w*][\w/*]*\.py\b", TEXTS)
    assert names
    missing = [(page, name) for page, name in names if not any(p.match(name) for p in PLACES)]
    assert missing == []


def test_files_that_comments_name_are_there() -> None:
    """In backticks or brackets, so that they cannot be names that a test makes up."""
    names = named(r"[`(]([\w*][\w/*]*\.py)[`),]", SOURCES)
    assert names
    missing = [(page, name) for page, name in names if not any(p.match(name) for p in PLACES)]
    assert missing == []


def test_modules_that_pages_name_are_there() -> None:
    """A dotted name in backticks is a module, or something that a module holds."""
    names = named(r"`((?:warp_softbody|benchmarks)(?:\.\w+)+)`", TEXTS | SOURCES)
    assert names
    assert [(page, name) for page, name in names if not known(name)] == []


def known(name: str) -> bool:
    module = name
    while module not in FILES:
        module = module.rpartition(".")[0]
        if not module:
            return False
    rest = name.removeprefix(module).lstrip(".").partition(".")[0]
    return (
        not rest or re.search(rf"\b{rest}\b", FILES[module].read_text(encoding="utf-8")) is not None
    )


COMMANDS = sorted(
    {name.rstrip(".") for _, name in named(r"-m (benchmarks[\w.]*)", TEXTS | SOURCES)}
)


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_that_pages_name_help(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [command, "--help"])
    # another test may have imported it
    monkeypatch.delitem(sys.modules, command, raising=False)
    with pytest.raises(SystemExit) as ended:
        runpy.run_module(command, run_name="__main__", alter_sys=True)
    assert ended.value.code == 0
    assert f"python -m {command}" in capsys.readouterr().out


def test_links_between_pages_lead_somewhere() -> None:
    missing = []
    for page, text in TEXTS.items():
        for target in re.findall(r"\]\(([^)\s#]+)(?:#[^)]*)?\)", text):
            if "://" not in target and not (ROOT / Path(page).parent / target).exists():
                missing.append((page, target))
    assert missing == []
