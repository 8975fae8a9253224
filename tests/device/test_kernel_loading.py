"""Kernels are compiled side by side before the first launch, and as well one by one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import warp as wp

from warp_softbody.device import kernel_loading
from warp_softbody.device.kernel_loading import load_side_by_side
from warp_softbody.device.warp_runtime import start
from warp_softbody.kernels.precision import real

NAMES = [f"warp_softbody.kernels.side_by_side_{k}.float32" for k in range(4)]


def add(number: int) -> object:
    """A kernel in a module of its own."""

    @real("float32").kernel(f"side_by_side_{number}")  # type: ignore[untyped-decorator]
    def add_constant(values: wp.array(dtype=wp.float32)):  # type: ignore[no-untyped-def, valid-type]
        values[wp.tid()] += float(number)

    return add_constant


def loaded() -> list[bool]:
    return [bool(wp.get_module(name).execs) for name in NAMES]


def test_modules_are_loaded_before_they_are_launched(monkeypatch: pytest.MonkeyPatch) -> None:
    start()
    kernels = [add(k) for k in range(len(NAMES))]
    load_side_by_side("cuda:0", NAMES)
    assert not any(loaded())
    monkeypatch.setattr(kernel_loading, "_workers", lambda: 2)
    load_side_by_side("cpu", NAMES)
    assert all(loaded())
    # nothing is left to do
    monkeypatch.setattr(kernel_loading, "_load", lambda module: pytest.fail("loaded again"))
    load_side_by_side("cpu", NAMES)
    values = wp.zeros(3, dtype=wp.float32, device="cpu")
    for kernel in kernels:
        wp.launch(kernel, dim=3, inputs=[values], device="cpu")
    found = values.numpy()  # type: ignore[no-untyped-call]
    assert found.tolist() == [6.0, 6.0, 6.0]


FAILING = """
import warp as wp
from warp_softbody.device.kernel_loading import load_side_by_side
from warp_softbody.device.warp_runtime import start
from warp_softbody.kernels.precision import real

types = real("float32")
for number in range(3):
    @types.kernel(f"failing_{number}")
    def unknown(values: wp.array(dtype=wp.float32)):
        values[0] = wp.no_such_function(values[0])

start()
try:
    load_side_by_side("cpu", [f"warp_softbody.kernels.failing_{k}.float32" for k in range(3)])
except Exception as error:
    print("no_such_function" in str(error))
"""


def test_what_cannot_be_built_is_told(tmp_path: Path) -> None:
    script = tmp_path / "failing.py"
    script.write_text(FAILING)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, str(script)]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert run.stdout == "True\n", run.stderr
