"""The wheel is whole: built, unpacked and used from an empty folder, away from the checkout."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ("warp_softbody", "kernels", "controllers", "stage_exports")
EVERY_MODULE = """
import importlib, pkgutil, sys
import warp_softbody
assert warp_softbody.__file__.startswith(sys.argv[1]), warp_softbody.__file__
names = [m.name for m in pkgutil.walk_packages(warp_softbody.__path__, "warp_softbody.")]
for name in names:
    if not name.endswith("__main__"):
        importlib.import_module(name)
assert not [name for name in sys.modules if name.partition(".")[0] in ("benchmarks", "tests")]
print(len(names))
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The unpacked wheel; built from a copy, so that the checkout stays as it is."""
    setuptools = pytest.importorskip("setuptools")
    if int(setuptools.__version__.partition(".")[0]) < 77:
        pytest.skip("the wheel is built with setuptools 77 or later")
    folder = tmp_path_factory.mktemp("wheel")
    for name in SOURCES:
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / "source" / name, symlinks=True, ignore=ignored)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder / "source")
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder))
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", *options, str(folder / "source")], check=True
    )
    (wheel,) = folder.glob("warp_softbody-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


@pytest.fixture
def python(installed: Path, tmp_path: Path) -> Callable[..., str]:
    """Run the interpreter in an empty folder, where only the wheel is; what it prints."""
    others = [path for path in sys.path if path and Path(path).resolve() != ROOT]
    path = os.pathsep.join([str(installed), *others])

    def run(*arguments: object) -> str:
        command = [sys.executable, *map(str, arguments)]
        environment = {**os.environ, "PYTHONPATH": path}
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def test_every_module_is_there(python: Callable[..., str], installed: Path) -> None:
    ours = [path for name in SOURCES for path in (ROOT / name).rglob("*.py")]
    # those of linked folders are found once; the package itself is not walked
    assert int(python("-c", EVERY_MODULE, installed)) == len({p.resolve() for p in ours}) - 1


def test_a_scene_is_run(python: Callable[..., str], tmp_path: Path) -> None:
    run = ("run", "cantilever", "--seconds", 0.1, "--json")
    text = python("-m", "warp_softbody", *run)
    assert json.loads(text)["status"] == "complete"
    assert list(tmp_path.iterdir()) == []
    python("-m", "warp_softbody", *run, "--html", "take.html")
    assert (tmp_path / "take.html").stat().st_size > 100_000


@pytest.mark.long
def test_a_scene_is_charted_and_tuned(python: Callable[..., str], tmp_path: Path) -> None:
    """A coarse chart of some 30 runs, and of its journal the settings for an error of 20 %."""
    pytest.importorskip("matplotlib")
    common = ("cantilever", "--quick", "--workers", 1, "--journal", "journal", "--json")
    (chart,) = json.loads(python("-m", "warp_softbody", "chart", *common, "--out", "."))["charts"]
    assert all((tmp_path / f"cantilever.{kind}").stat().st_size for kind in ("csv", "json", "png"))
    assert chart["scene"] == "cantilever"
    stored = ("--error", "20%", "--out", "tuned.json")
    tuned = json.loads(python("-m", "warp_softbody", "tune", *common, *stored))
    assert tuned["bound"] == 0.2 and (tmp_path / "tuned.json").stat().st_size
