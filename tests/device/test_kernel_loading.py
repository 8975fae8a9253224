"""Kernels are compiled side by side before the first launch, and only those that are launched."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import warp as wp

from warp_softbody.device import kernel_loading
from warp_softbody.device.kernel_loading import (
    asked_for,
    forget_builds,
    is_compiling,
    load,
    prepare,
)
from warp_softbody.device.launching import launch
from warp_softbody.device.warp_runtime import captured, prepare_captures, start
from warp_softbody.kernels.precision import real


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Path]:
    """An empty folder of compiled kernels."""
    start()
    before = wp.config.kernel_cache_dir
    wp.config.kernel_cache_dir = str(tmp_path)
    forget_builds()
    yield tmp_path
    forget_builds()
    wp.config.kernel_cache_dir = before


def adding(subject: str, part: str = "") -> Any:
    """A kernel that adds 1, in a module of its own."""

    @real("float32").kernel(subject, part)  # type: ignore[untyped-decorator]
    def add_one(  # type: ignore[no-untyped-def]
        # in and out
        values: wp.array(dtype=wp.float32),  # type: ignore[valid-type]
    ):
        values[wp.tid()] += 1.0

    return add_one


def numbers(values: Any) -> list[float]:
    return list(values.numpy().tolist())


def built(folder: Path) -> set[str]:
    """The subjects of modules on the disk, but for that of the header."""
    subjects = {path.name.split(".")[2] for path in folder.iterdir()}
    return subjects - {"header"}


def test_modules_are_compiled_before_they_are_launched(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernels = [adding(f"side_by_side_{k}") for k in range(3)]
    load("cuda:0", kernels)
    assert not any(kernel.module.execs for kernel in kernels)
    monkeypatch.setattr(kernel_loading, "_workers", lambda: 2)
    load("cpu", kernels)
    assert all(kernel.module.execs for kernel in kernels)
    assert built(folder) == {f"side_by_side_{k}" for k in range(3)}
    # nothing is left to do
    monkeypatch.setattr(kernel_loading, "_load", lambda module: pytest.fail("loaded again"))
    prepare("cpu", kernels)
    load("cpu", kernels)
    values = wp.zeros(3, dtype=wp.float32, device="cpu")
    for kernel in kernels:
        launch(kernel, 3, [], [values], "cpu")
    assert numbers(values) == [3.0, 3.0, 3.0]


def test_a_graph_compiles_what_it_launches_and_no_more(folder: Path) -> None:
    first, second, plain = adding("launched_1"), adding("launched_2"), adding("launched_1", "plain")
    values = wp.zeros(1, dtype=wp.float32, device="cpu")

    def launches() -> None:
        for kernel in (first, second, first):
            launch(kernel, 1, [], [values], "cpu")

    graph = captured("cpu", launches)
    assert built(folder) == {"launched_1", "launched_2"}
    assert not plain.module.execs
    # launches that were left out while kernels were missing are made once
    assert numbers(values) == [0.0]
    wp.capture_launch(graph)
    assert numbers(values) == [3.0]


def test_what_is_asked_for_is_not_launched(folder: Path) -> None:
    kernel = adding("asked_for")
    values = wp.zeros(1, dtype=wp.float32, device="cpu")
    assert asked_for(lambda: launch(kernel, 1, [], [values], "cpu")) == {kernel}
    assert numbers(values) == [0.0]
    assert not built(folder)


def test_captures_are_prepared_where_kernels_are_compiled_at_all(folder: Path) -> None:
    kernel, other = adding("prepared"), adding("prepared_first")
    values = wp.zeros(1, dtype=wp.float32, device="cpu")

    def launches() -> None:
        launch(kernel, 1, [], [values], "cpu")

    prepare_captures("cpu", launches)
    assert not is_compiling()
    prepare("cpu", [other])
    assert is_compiling()
    prepare_captures("cpu", launches)
    load("cpu", [kernel, other])
    assert built(folder) == {"prepared", "prepared_first"}
    assert numbers(values) == [0.0]


def test_what_is_on_the_disk_is_not_compiled(folder: Path) -> None:
    kernel = adding("on_the_disk")
    load("cpu", [kernel])
    kernel.module.unload()
    forget_builds()
    launch(kernel, 1, [], [wp.zeros(1, dtype=wp.float32, device="cpu")], "cpu")
    assert kernel.module.execs
    assert not is_compiling()


FAILING = """
import warp as wp
from warp_softbody.device.kernel_loading import load
from warp_softbody.device.warp_runtime import start
from warp_softbody.kernels.precision import real

types = real("float32")

def failing(number):
    @types.kernel(f"failing_{number}")
    def unknown(values: wp.array(dtype=wp.float32)):
        values[0] = wp.no_such_function(values[0])
    return unknown

start()
for attempt in range(2):
    try:
        load("cpu", [failing(number) for number in range(3)])
    except Exception as error:
        print("no_such_function" in str(error))
"""


def test_what_cannot_be_built_is_told(tmp_path: Path) -> None:
    script = tmp_path / "failing.py"
    script.write_text(FAILING)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, str(script)]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert run.stdout == "True\nTrue\n", run.stderr
