"""What a command does not need it does not load."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from warp_softbody import scenes

ROOT = Path(__file__).parents[2]
HEAVY = ("pxr", "embreex", "imageio", "trimesh", "meshio", "matplotlib", "scipy.spatial")
"""Modules of stages, pictures, meshers and charts, each a tenth of a second and more."""

LOADED = """
import json, sys
from warp_softbody.cli import main
main({})
print(json.dumps([*sys.modules]))
"""


def loaded(*arguments: str) -> set[str]:
    """Names of the modules that a command line has loaded when it ends."""
    run = subprocess.run(
        [sys.executable, "-c", LOADED.format([*arguments])],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return set(json.loads(run.stdout.strip().splitlines()[-1]))


OWN = ("coarse_meshes", "crawl_i", "plan", "pushes", "uneven_ground")
"""Files of the scenes that one of them needs."""


def test_a_run_without_files_loads_no_libraries_of_files() -> None:
    modules = loaded("run", "crawl-i", "--seconds", "0.02", "--quiet")
    assert "warp_softbody.run.simulation" in modules
    assert not modules & set(HEAVY)
    # of all scenes its own alone
    own = {name for name in modules if name.startswith("warp_softbody.scenes.")}
    assert own == {f"warp_softbody.scenes.{name}" for name in OWN}


def test_every_scene_is_found_under_its_name() -> None:
    assert len(scenes.names()) > 20
    for name in scenes.names():
        assert scenes.recipe(name).name == name
