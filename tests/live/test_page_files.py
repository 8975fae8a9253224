"""The files of the pages: modules that fit together, and nothing from anywhere else."""

from __future__ import annotations

import gzip
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from warp_softbody.live import page_files
from warp_softbody.live.page_files import EXPORT, IMPORT, PAGE

MODULES = sorted(PAGE.glob("*.js"))
DECLARED = re.compile(r"^(?:export )?(?:async )?(?:class|function|const|let) (\w+)", re.MULTILINE)


def source(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.name))
def test_a_module_can_be_linked(path: Path) -> None:
    """Its imports are by name alone, from files that are there and export these names."""
    text = source(path)
    lines = [line for line in text.splitlines() if line.startswith(("import", "export"))]
    for line in lines:
        assert re.match(r"(import \{|export (async )?(class|function|const) \w)", line), line
    for statement in IMPORT.finditer(text):
        other = source(PAGE / f"{statement.group(1)}.js")
        names = [name.strip() for name in statement.group(0).split("{")[1].split("}")[0].split(",")]
        for name in filter(None, names):
            assert re.search(rf"^export (?:async )?(?:class|function|const) {name}\b", other, re.M)
    assert len(IMPORT.findall(text)) == text.count("\nimport {") + text.startswith("import {")
    assert len(EXPORT.findall(text)) == sum(line.startswith("export") for line in lines)


def test_modules_share_no_name() -> None:
    names = [name for path in MODULES for name in DECLARED.findall(source(path))]
    assert len(names) == len(set(names)), sorted(n for n in set(names) if names.count(n) > 1)


def test_files_are_small_and_name_no_address() -> None:
    for path in (*MODULES, *PAGE.glob("*.css"), *PAGE.glob("*.html")):
        text = source(path)
        assert text.count("\n") < 250, path.name
        assert not re.search(r"https?://|//[a-z]+\.|@import|url\(|eval\(|innerHTML", text), (
            path.name
        )


def test_linked_modules_stand_after_those_that_they_import() -> None:
    text = page_files.linked("take.js")
    places = [text.index(f"class {name} ") for name in ("Arrows", "Overlays", "Viewer", "Player")]
    assert places == sorted(places)
    assert not re.search(r"^(import|export) ", text, re.MULTILINE)


def test_the_vendored_library_has_its_licence() -> None:
    text = gzip.decompress(page_files.packed_three()).decode()
    assert text.count("OrbitControls") >= 1 and "THREE" in text[:20]
    assert "MIT License" in page_files.three_licence()
    assert "three.js authors" in page_files.three_licence()
    assert sum(path.stat().st_size for path in (PAGE / "vendor").iterdir()) < 160_000


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_scripts_are_javascript(tmp_path: Path) -> None:
    for name, text in {
        "player.mjs": page_files.player_script(),
        "live.mjs": page_files.linked("live.js"),
        "start.mjs": source(PAGE / "take_start.js"),
    }.items():
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        subprocess.run(["node", "--check", path], check=True, timeout=60)
