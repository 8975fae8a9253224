"""Programs that read stages, each in an environment that `make test-viewers` has made."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.support.import_graph import ROOT
from warp_softbody import scenes
from warp_softbody.run.simulation import Simulation
from warp_softbody.stage_exports import StageWriter

HOME = ROOT / "out" / "viewers"
PROGRAMS = Path(__file__).parent / "programs"

RunProgram = Callable[..., dict[str, Any]]
StageOf = Callable[..., Path]


@pytest.fixture
def program() -> RunProgram:
    """Run a program by its name and arguments, and hand back what it prints as JSON last."""

    def run(environment: str, name: str, *arguments: object) -> dict[str, Any]:
        python = HOME / environment / "bin" / "python"
        if not python.exists():
            pytest.skip(f"make test-viewers installs {environment}")
        command = [str(python), str(PROGRAMS / f"{name}.py"), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=3000, check=False)
        assert done.returncode == 0, done.stderr[-2000:]
        answer: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
        return answer

    return run


@pytest.fixture(scope="session")
def stage_of(tmp_path_factory: pytest.TempPathFactory) -> StageOf:
    """The stage of the first frames of a scene, made once."""
    folder = tmp_path_factory.mktemp("stages")

    def make(name: str, seconds: float = 0.2) -> Path:
        path = folder / f"{name}.usdc"
        if not path.exists():
            plan = scenes.make(name)
            simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
            with StageWriter(path, plan.scene) as stage:
                for frame in simulation.run(seconds):
                    stage.write(frame)
        return path

    return make
