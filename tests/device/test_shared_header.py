"""Compilers share one precompiled header, and what they compile with it is the same."""

from __future__ import annotations

import threading
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
import warp as wp

from warp_softbody.device import shared_header
from warp_softbody.device.kernel_loading import forget_builds, load
from warp_softbody.device.shared_header import SharedHeader
from warp_softbody.device.warp_runtime import start
from warp_softbody.kernels.precision import real


@pytest.fixture
def folders(monkeypatch: pytest.MonkeyPatch) -> dict[int, Any]:
    """Folders of headers by thread, in place of Warp's."""
    made: dict[int, Any] = {}
    monkeypatch.setattr(shared_header, "_folders", lambda: made)
    return made


def in_threads(count: int, work: Any) -> None:
    threads = [threading.Thread(target=work, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def test_the_first_is_alone_and_leaves_its_header_to_all(folders: dict[int, Any]) -> None:
    header = SharedHeader()
    at_work: list[None] = []
    most: list[int] = []
    seen: list[Any] = []

    def build() -> None:
        at_work.append(None)
        most.append(len(at_work) if not seen else 0)
        own = folders.setdefault(threading.get_ident(), TemporaryDirectory())
        if not seen:
            Path(own.name, "builtin.pch").touch()
        seen.append(own)
        at_work.pop()

    in_threads(6, lambda number: header.compile(build))
    assert len(seen) == 6
    assert max(most) == 1
    assert all(own is seen[0] for own in seen)


def test_without_a_header_every_thread_keeps_to_itself(folders: dict[int, Any]) -> None:
    header, built = SharedHeader(), []
    in_threads(3, lambda number: header.compile(lambda: built.append(number)))
    assert sorted(built) == [0, 1, 2]
    assert not folders


def test_a_first_module_that_fails_leaves_the_others_to_be_built(folders: dict[int, Any]) -> None:
    header, built = SharedHeader(), []

    def fail() -> None:
        raise OSError("disk is full")

    with pytest.raises(OSError, match="disk is full"):
        header.compile(fail)
    header.compile(lambda: built.append(True))
    assert built == [True]


def test_warp_still_keeps_headers_by_thread() -> None:
    """What is shared is a part of Warp that it does not promise; without it, all is slower."""
    start()
    runtime: Any = wp._src.context.runtime
    mine = runtime.get_clang_pch_dir()
    assert shared_header._folders()[threading.get_ident()].name == mine


def test_objects_are_those_of_warp_alone(tmp_path: Path) -> None:
    types = real("float32")

    def make(number: int) -> Any:
        @types.kernel(f"alike_{number}")  # type: ignore[untyped-decorator]
        def scale(  # type: ignore[no-untyped-def]
            # in and out
            values: wp.array(dtype=wp.vec3f),  # type: ignore[valid-type]
        ):
            i = wp.tid()
            values[i] = wp.normalize(values[i]) * wp.sqrt(values[i][number])

        return scale

    start()
    kernels, before = [make(number) for number in range(3)], wp.config.kernel_cache_dir
    try:
        for name in ("shared", "alone"):
            wp.config.kernel_cache_dir = str(tmp_path / name)
            forget_builds()
            for kernel in kernels:
                kernel.module.unload()
            if name == "shared":
                load("cpu", kernels)
            else:
                modules = [kernel.module for kernel in kernels]
                wp.force_load("cpu", modules=modules, max_workers=0)
    finally:
        forget_builds()
        wp.config.kernel_cache_dir = before
    objects = {path.relative_to(tmp_path / "alone") for path in tmp_path.glob("alone/*/*.o")}
    assert len(objects) == 3
    for path in objects:
        assert (tmp_path / "shared" / path).read_bytes() == (tmp_path / "alone" / path).read_bytes()
