"""What is compiled before a simulation is built is what it launches, and is compiled once."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run import early_kernels

SCRIPT = """
import sys
from warp_softbody import scenes
from warp_softbody.controllers.compiled.search_kernels import search_kernels
from warp_softbody.engine.first_kernels import first_kernels, muscle_kernels, reduced_kernels
from warp_softbody.device.warp_runtime import start
from warp_softbody.run.simulation import Simulation

start()
plan = scenes.make(sys.argv[1])
kernels = first_kernels("float32")
if plan.controller is not None:
    kernels += search_kernels() + muscle_kernels("float32") + reduced_kernels("float32")
modules = {kernel.module: kernel.module.get_module_identifier(1) for kernel in kernels}
simulation = Simulation(plan.scene, plan.controller, time_step=1 / 60)
simulation.step()
simulation.step()
print([name for module, name in modules.items() if not module.execs])
print([name for module, name in modules.items() if module.get_module_identifier(1) != name])
"""


@pytest.mark.parametrize("scene", ["cantilever", "drop-block", "balance-i"])
def test_all_of_it_is_launched_and_whole(scene: str, tmp_path: Path) -> None:
    script = tmp_path / "early.py"
    script.write_text(SCRIPT)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, str(script), scene]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert run.stdout == "[]\n[]\n", run.stderr


@pytest.mark.parametrize(
    "options",
    [SimulationOptions(device="cuda:0"), SimulationOptions(native_code=False)],
    ids=["another device", "plain kernels"],
)
def test_native_code_stays_out_of_modules_that_have_none(
    options: SimulationOptions, monkeypatch: pytest.MonkeyPatch
) -> None:
    def made(*_: object) -> list[object]:
        pytest.fail("kernels of native code were made")

    monkeypatch.setattr(early_kernels, "check_device", lambda device: None)
    for name in ("first_kernels", "muscle_kernels", "reduced_kernels", "search_kernels"):
        monkeypatch.setattr(early_kernels, name, made)
    early_kernels.prepare_kernels(options, controlled=True)
