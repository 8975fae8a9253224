"""Kernels are compiled side by side, and those alone that are launched.

Left to itself Warp compiles a module when the first of its kernels is launched: one by one.
Clang takes nine tenths of that time, and needs nothing of Python's meanwhile. So whoever knows
what will be launched says so early (`prepare`), and what waits for kernels waits for all of them
at once (`load`). Modules on the disk are loaded at once, where they are asked for. Warp's header,
with which every module begins, is compiled before the first of them (`prepare_header`).
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from typing import Any

import warp as wp

from warp_softbody.device.shared_header import SharedHeader
from warp_softbody.kernels.header import make_header

MOST_WORKERS = 8
"""Compilers at work at once; each takes some 200 MB."""

THREADS_OF_A_BLOCK = 1
"""Of launches on processors, for which modules have files of their own."""

_builds: dict[Any, Future[None]] = {}
"""Modules that are compiled, or are to be."""

_header = SharedHeader()
"""What the compilers of this process share."""

_asked: list[set[Any]] = []
"""Not empty while launches are told apart: those that cannot be made are put down in the last."""

_none_is_made: list[bool] = []
"""Not empty while no launch is made, but each put down."""


def is_compiling() -> bool:
    """Whether this process has found a module that is not on the disk."""
    return bool(_builds)


def prepare_header(device: str) -> None:
    """Begin to compile Warp's header where no kernel has been compiled on this machine yet.

    For whoever knows that there will be launches, but not yet of what.
    """
    module = make_header().nothing.module
    if _is_processor(device) and module not in _builds and not _is_compiled(module):
        _begin(module)


def prepare(device: str, kernels: Iterable[Any]) -> None:
    """Begin to compile the modules of kernels that will be launched, as far as they are not yet.

    Modules for graphics cards are left to their launches.
    """
    if _is_processor(device):
        for module in _modules(kernels):
            if module not in _builds and not _is_loaded(module) and not _is_compiled(module):
                prepare_header(device)
                _begin(module)


def load(device: str, kernels: Iterable[Any]) -> None:
    """Load the modules of kernels, compiled on all cores that this process may use."""
    if not _is_processor(device):
        return
    kernels = list(kernels)
    prepare(device, kernels)
    for module in _modules(kernels):
        if module in _builds:
            try:
                _builds[module].result()
            except BaseException:
                _builds.pop(module, None)
                raise
        if not _is_loaded(module):
            _load(module)


def can_launch(device: str, kernel: Any) -> bool:
    """Whether a launch can be made; what is missing is loaded, or put down for later."""
    if _none_is_made:
        _asked[-1].add(kernel)
        return False
    if not _is_processor(device) or _is_loaded(kernel.module):
        return True
    if not _asked or _is_compiled(kernel.module):
        load(device, [kernel])
        return True
    _asked[-1].add(kernel)
    return False


def missing(launch: Callable[[], None]) -> set[Any]:
    """Launch what can be; return kernels that could not, for they are still to be compiled."""
    return _put_down(launch)


def asked_for(launch: Callable[[], None]) -> set[Any]:
    """The kernels that ``launch`` launches; none is launched."""
    _none_is_made.append(True)
    try:
        return _put_down(launch)
    finally:
        _none_is_made.pop()


def forget_builds() -> None:
    """Let modules be compiled again, once those that are at work have ended."""
    for build in [*_builds.values()]:
        if not build.cancel():
            build.exception()
    _builds.clear()


def _put_down(launch: Callable[[], None]) -> set[Any]:
    found: set[Any] = set()
    _asked.append(found)
    try:
        launch()
    finally:
        _asked.pop()
    return found


def _modules(kernels: Iterable[Any]) -> list[Any]:
    """Those of kernels, each once, in their order."""
    return list(dict.fromkeys(kernel.module for kernel in kernels))


def _is_processor(device: str) -> bool:
    return device == "cpu"


def _is_loaded(module: Any) -> bool:
    """Whether a module can be launched on the processor."""
    return any(context is None for context, _ in module.execs)


def _is_compiled(module: Any) -> bool:
    """Whether a module is on the disk, for this processor or a similar one."""
    name = module.get_module_identifier(THREADS_OF_A_BLOCK)
    return os.path.isdir(os.path.join(str(wp.config.kernel_cache_dir), name))


def _begin(module: Any) -> None:
    """Have a module compiled by the next thread that is free."""
    _builds[module] = _pool().submit(_build, module)


def _build(module: Any) -> None:
    """Compile and load, unless the process is about to end."""
    if threading.main_thread().is_alive() and not _is_loaded(module):
        _header.compile(lambda: _load(module))


def _load(module: Any) -> None:
    wp.force_load("cpu", modules=[module], max_workers=0)


@cache
def _pool() -> ThreadPoolExecutor:
    """Threads that compile."""
    return ThreadPoolExecutor(max_workers=_workers(), thread_name_prefix="kernels")


def _workers() -> int:
    """Cores that this process may use, within reason."""
    try:
        count = len(os.sched_getaffinity(0))
    except AttributeError:
        count = os.cpu_count() or 1
    return min(count, MOST_WORKERS)
