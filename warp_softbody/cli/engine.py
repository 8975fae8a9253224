"""Starts Warp without its banner, keeps its messages off stdout and finds the device."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from warp_softbody.cli.output import note
from warp_softbody.errors import InputError


class _Messages:
    """A Warp logger: warnings and errors to stderr, the rest is heard but not printed."""

    def __init__(self, on_compile: Callable[[], None]) -> None:
        self._on_compile = on_compile

    def debug(self, message: str) -> None:
        """Print nothing."""

    def info(self, message: str) -> None:
        """Notice that a module had to be compiled."""
        if message.endswith("(compiled)"):
            self._on_compile()

    def warning(self, message: str, category: object = None, stacklevel: int = 1) -> None:
        """Print a line."""
        note(f"warp: {message}\n")

    def error(self, message: str) -> None:
        """Print a line."""
        note(f"warp: {message}\n")


@contextmanager
def warp_engine(device: str, on_compile: Callable[[], None]) -> Iterator[None]:
    """Warp, started and speaking softly, for the length of a `with` body.

    Raises:
        InputError: one sentence, when there is no such device.
    """
    import warp as wp

    wp.set_logger(_Messages(on_compile))
    try:
        with _native_messages_off():
            wp.init()  # type: ignore[no-untyped-call]
        _check_device(device)
        yield
    finally:
        wp.set_logger(None)


def _check_device(device: str) -> None:
    import warp as wp

    known = [str(found) for found in wp.get_devices()]
    # Asking Warp for "cuda" without a driver prints errors of its own.
    if device not in known and not (device == "cuda" and wp.is_cuda_available()):
        raise InputError(f"there is no device {device!r} here; known: {', '.join(known)}")


@contextmanager
def _native_messages_off() -> Iterator[None]:
    """Drop what compiled code writes to stderr, such as that there is no graphics driver."""
    sys.stderr.flush()
    saved = os.dup(2)
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(nothing)
