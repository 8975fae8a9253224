"""What the package asks of Warp as a whole: quiet, one capture at a time, devices, kernels on disk.

Warp keeps compiled kernels in a folder. Where that is damaged or cannot be written they are built
again, in a temporary folder if need be; only where this fails too there is an error.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import warp as wp

from warp_softbody.device.kernel_loading import (
    asked_for,
    forget_builds,
    is_compiling,
    load,
    missing,
    prepare,
)
from warp_softbody.device.turns import TURNS
from warp_softbody.errors import InputError, OutputError, SoftBodyError

OURS = "wp_warp_softbody.kernels."
"""How the folders of this package's kernels begin in Warp's."""

NAMED = re.compile(r"(?:CPU|CUDA|from) module '(\S+)'")
"""What Warp says of a module that it cannot load, or in which it does not find a kernel."""

_temporary: list[tempfile.TemporaryDirectory[str]] = []
"""The folder in place of Warp's own, once there is one; it goes with the process."""

_kept: list[Any] = []
"""What was loaded of damaged modules."""


_talks: list[bool] = []
"""Whether the user wants Warp's lines about modules: not empty if so."""


def set_quiet(*, silent: bool) -> None:
    """Let Warp tell errors alone, or all."""
    wp.config.log_level = wp.LOG_ERROR if silent else wp.LOG_INFO
    _talks[:] = [] if silent else [True]


def start() -> None:
    """Start Warp, if it is not yet, without its banner and its lines about modules.

    A user who has set ``wp.config.log_level`` keeps it.

    Raises:
        OutputError: there is no place for compiled kernels.
    """
    if wp.config.log_level == wp.LOG_INFO and not _talks:
        wp.config.log_level = wp.LOG_WARNING
    with TURNS.alone():
        try:
            with native_messages_off():
                wp.init()  # type: ignore[no-untyped-call]
        except OSError as error:
            wp.config.kernel_cache_dir = _other_folder(error)
            with native_messages_off():
                wp.init()  # type: ignore[no-untyped-call]


def kernel_folder() -> str:
    """Where compiled kernels are kept on this machine."""
    start()
    return str(wp.config.kernel_cache_dir)


def captured(device: str, launch: Callable[[], None]) -> Any:
    """The graph of what ``launch`` launches on a device; its kernels are loaded on the way.

    Raises:
        OutputError: they can neither be loaded nor built.
    """

    def capture() -> Any:
        with wp.ScopedCapture(device=device) as scope:
            kernels = missing(launch)
        if not kernels:
            return scope.graph
        # launches were left out
        load(device, kernels)
        return capture()

    with TURNS.alone():
        return with_kernels(capture)


def prepare_captures(device: str, launch: Callable[[], None]) -> None:
    """Begin to compile what ``launch`` launches, where this process compiles at all.

    Whoever launches later waits the less. Nothing is launched here.
    """
    if device != "cpu" or not is_compiling():
        return
    with TURNS.alone(), wp.ScopedCapture(device=device):
        kernels = asked_for(launch)
    prepare(device, kernels)


def with_kernels(use: Callable[[], Any]) -> Any:
    """The result of ``use``, which may load kernels and can be begun anew.

    It is begun anew with damaged kernels removed, then with an empty temporary folder.

    Raises:
        OutputError: the kernels can neither be loaded nor built.
    """
    try:
        return use()
    except Exception as error:
        if isinstance(error, SoftBodyError) or not _is_of_kernels(error):
            raise
        failure = error
    tried: set[str] = set()
    with TURNS.alone():
        while True:
            renew = _move if str(failure) in tried else _forget_damaged
            tried.add(str(failure))
            renew(failure)
            try:
                return use()
            except Exception as error:
                if isinstance(error, SoftBodyError) or not _is_of_kernels(error):
                    raise
                failure = error


def check_device(device: str) -> None:
    """Refuse a device that Warp does not find here.

    Raises:
        InputError: the sentence, with the devices that there are.
    """
    start()
    known = [str(found) for found in wp.get_devices()]
    # asking Warp for "cuda" without a driver prints errors of its own
    if device not in known and not (device == "cuda" and wp.is_cuda_available()):
        raise InputError(f"there is no device {device!r} here; known: {', '.join(known)}")


@contextmanager
def native_messages_off() -> Iterator[None]:
    """Drop what compiled code writes to stderr, such as that there is no graphics driver."""
    if sys.stderr is not None:
        with suppress(OSError, ValueError):
            sys.stderr.flush()
    try:
        saved = os.dup(2)
    except OSError:
        # stderr is closed: nothing can be written to it
        yield
        return
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nothing)


def _is_of_kernels(error: Exception) -> bool:
    """Whether an error came from loading or building kernels."""
    if isinstance(error, OSError) or NAMED.search(str(error)):
        return True
    trace = error.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        if code.co_name == "load" and "warp" in Path(code.co_filename).parts:
            return True
        trace = trace.tb_next
    return False


def _forget_damaged(error: Exception) -> None:
    """Remove kernels that are damaged, so that they are built again.

    Where the disk is full or the folder cannot be written, what it holds stays.
    """
    there = (errno.ENOENT, errno.EISDIR, errno.ENOTDIR)
    if isinstance(error, OSError) and error.errno not in there:
        return
    folder, named = Path(wp.config.kernel_cache_dir or ""), NAMED.search(str(error))
    found = folder.glob(f"wp_{named.group(1)}_*" if named else f"{OURS}*")
    damaged = [kernels for kernels in found if named or not _is_whole(kernels)]
    if damaged:
        _tell(f"kernels in {folder} are damaged and are built again")
    for kernels in damaged:
        shutil.rmtree(kernels, ignore_errors=True)
    if named:
        module = wp.get_module(named.group(1))
        # graphs may hold kernels of it that are good
        _kept.append(module.execs)
        module.unload()  # type: ignore[no-untyped-call]
    _forget_failures()


def _is_whole(kernels: Path) -> bool:
    """Whether what Warp notes beside a module's kernels can be read, and there is something."""
    try:
        notes = [json.loads(path.read_text(encoding="utf-8")) for path in kernels.glob("*.meta")]
        binaries = [path.stat().st_size for path in kernels.glob("*.o")]
    except (OSError, ValueError):
        return False
    return bool(notes) and bool(binaries) and min(binaries) > 0


def _move(error: Exception) -> None:
    """Let Warp keep kernels in a temporary folder."""
    wp.config.kernel_cache_dir = _other_folder(error)
    _forget_failures()


def _other_folder(error: Exception) -> str:
    """An empty temporary folder, with a line on stderr that tells why.

    Raises:
        OutputError: there is no room for one either.
    """
    if _temporary:
        raise OutputError(
            f"Warp's kernels can neither be loaded nor built in {wp.config.kernel_cache_dir}: "
            f"{_reason(error)}"
        ) from error
    try:
        _temporary.append(tempfile.TemporaryDirectory(prefix="warp_softbody_kernels_"))
    except OSError as second:
        raise OutputError(
            f"Warp's kernels cannot be stored in {wp.config.kernel_cache_dir} ({_reason(error)}), "
            f"nor in a temporary folder ({_reason(second)})"
        ) from second
    _tell(
        f"{wp.config.kernel_cache_dir} cannot hold Warp's kernels ({_reason(error)}); "
        "they are built in a temporary folder for this run"
    )
    return _temporary[0].name


@cache
def _tell(sentence: str) -> None:
    """A line on stderr, if there is one; the same only once."""
    if sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(f"warp-softbody: {sentence}", file=sys.stderr)


def _forget_failures() -> None:
    """Warp remembers that a module could not be built; let it try again."""
    from warp_softbody.kernels.precision import MODULES

    forget_builds()
    for name in MODULES:
        wp.get_module(name).mark_modified()  # type: ignore[no-untyped-call]


def _reason(error: Exception) -> str:
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return " ".join(str(error).split()) or type(error).__name__
