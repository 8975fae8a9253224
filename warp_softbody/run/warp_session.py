"""Starts Warp without its banner, keeps its messages off stdout and finds the device."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress


def _note(text: str) -> None:
    """Print on standard error, where somebody takes it."""
    with suppress(OSError, ValueError):
        print(text, end="", file=sys.stderr, flush=True)


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
        _note(f"warp: {message}\n")

    def error(self, message: str) -> None:
        """Print a line."""
        _note(f"warp: {message}\n")


@contextmanager
def warp_engine(device: str, on_compile: Callable[[], None]) -> Iterator[None]:
    """Warp, started and speaking softly, for the length of a `with` body.

    Raises:
        InputError: one sentence, when there is no such device.
        OutputError: there is no place for compiled kernels.
    """
    import warp as wp

    from warp_softbody.device.kernel_loading import prepare_header
    from warp_softbody.device.warp_runtime import check_device

    check_device(device)
    level = wp.config.log_level
    # so that Warp tells of what it compiles
    wp.config.log_level = wp.LOG_INFO
    wp.set_logger(_Messages(on_compile))
    prepare_header(device)
    try:
        yield
    finally:
        wp.set_logger(None)
        wp.config.log_level = level
