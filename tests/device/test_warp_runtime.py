"""Warp as a whole: kernels that are damaged or find no room, devices, and that it is quiet."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import warp as wp

import warp_softbody as wsb
from warp_softbody.device import warp_runtime
from warp_softbody.errors import InputError

SCRIPT = """
import warp as wp
from warp_softbody.kernels.precision import real
from warp_softbody.device.warp_runtime import captured, start

@real("float32").kernel("sample")
def add_one(values: wp.array(dtype=wp.float32)):
    values[wp.tid()] += 1.0

start()
values = wp.zeros(3, dtype=wp.float32, device="cpu")
graph = captured("cpu", lambda: wp.launch(add_one, dim=3, inputs=[values], device="cpu"))
wp.capture_launch(graph)
print(values.numpy().tolist())
"""

NO_ROOM = """
import warp as wp
from warp_softbody.device.warp_runtime import start, with_kernels
from warp_softbody.errors import OutputError

tries = []

def build():
    tries.append(wp.config.kernel_cache_dir)
    raise OSError(28, "No space left on device")

start()
try:
    with_kernels(build)
except OutputError as error:
    print(len(set(tries)), error)
"""


def run_sample(folder: Path, cache: Path, text: str = SCRIPT) -> subprocess.CompletedProcess[str]:
    """Run a script in a process of its own, with a folder for its kernels."""
    script = folder / "sample.py"
    script.write_text(text)
    environment = {**os.environ, "WARP_CACHE_PATH": str(cache)}
    return subprocess.run(
        [sys.executable, str(script)], env=environment, capture_output=True, text=True, check=False
    )


def test_damaged_kernels_are_built_again(tmp_path: Path) -> None:
    cache = tmp_path / "kernels"
    first = run_sample(tmp_path, cache)
    assert (first.stdout, first.stderr) == ("[1.0, 1.0, 1.0]\n", "")
    (binary,) = cache.glob("*/*sample*/*.o")
    size = binary.stat().st_size
    binary.write_bytes(binary.read_bytes()[: size // 2])
    again = run_sample(tmp_path, cache)
    assert again.stdout == "[1.0, 1.0, 1.0]\n"
    assert "are damaged and are built again" in again.stderr
    assert binary.stat().st_size == size


@pytest.mark.parametrize("damage", ["", "{", None])
def test_notes_that_cannot_be_read_are_damage(tmp_path: Path, damage: str | None) -> None:
    (tmp_path / "kernels.o").write_bytes(b"code")
    notes = tmp_path / "kernels.meta"
    notes.write_text("{}")
    assert warp_runtime._is_whole(tmp_path)
    if damage is None:
        notes.unlink()
    else:
        notes.write_text(damage)
    assert not warp_runtime._is_whole(tmp_path)


def test_kernels_without_a_folder_go_to_a_temporary_one(tmp_path: Path) -> None:
    cache = tmp_path / "kernels"
    cache.write_text("a file")
    ended = run_sample(tmp_path, cache)
    assert ended.stdout == "[1.0, 1.0, 1.0]\n"
    assert "they are built in a temporary folder for this run" in ended.stderr
    assert len(ended.stderr.splitlines()) == 1
    assert cache.read_text() == "a file"


def test_kernels_that_find_no_room_at_all_are_one_sentence(tmp_path: Path) -> None:
    ended = run_sample(tmp_path, tmp_path / "kernels", NO_ROOM)
    # at once, once more, and in a temporary folder once and once more
    number, sentence = ended.stdout.rstrip().split(" ", 1)
    assert number == "2"
    assert "can neither be loaded nor built in" in sentence
    assert sentence.endswith(": No space left on device")
    assert len(ended.stderr.splitlines()) == 1


def test_other_errors_are_not_touched() -> None:
    def fail() -> None:
        raise ValueError("of the user")

    with pytest.raises(ValueError, match="of the user"):
        warp_runtime.with_kernels(fail)


def test_a_device_that_is_not_there() -> None:
    warp_runtime.check_device("cpu")
    with pytest.raises(InputError, match="there is no device 'cuda:77' here; known: cpu"):
        warp_runtime.check_device("cuda:77")


def test_quiet_and_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wp.config, "log_level", wp.LOG_INFO)
    monkeypatch.setattr(warp_runtime, "_talks", [])
    wsb.quiet()
    warp_runtime.start()
    assert wp.config.log_level == wp.LOG_ERROR
    wsb.quiet(False)
    warp_runtime.start()
    assert wp.config.log_level == wp.LOG_INFO
    with pytest.raises(InputError, match="silent of quiet"):
        wsb.quiet("yes")  # type: ignore[arg-type]
