"""Warp's header, precompiled once a process and not once in each thread that compiles.

Every module begins with the same header of 1.5 MB, which clang takes a second to read. Warp keeps
it precompiled for a thread's further modules, in a folder a thread, so that no two write the same
file. Here compilers have one folder, and the first module is compiled alone.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import warp as wp


class SharedHeader:
    """One precompiled header for all threads that compile through it."""

    def __init__(self) -> None:
        """Not there yet."""
        self._first = threading.Lock()
        self._is_tried = threading.Event()
        self._folder: TemporaryDirectory[str] | None = None

    def compile(self, build: Callable[[], None]) -> None:
        """Let ``build`` compile modules; the first of all is alone, as it makes the header."""
        if not self._is_tried.is_set():
            with self._first:
                if not self._is_tried.is_set():
                    self._build_first(build)
                    return
        if self._folder is not None:
            _folders()[threading.get_ident()] = self._folder
        build()

    def _build_first(self, build: Callable[[], None]) -> None:
        """Build; what this leaves in the thread's folder is everybody's."""
        try:
            build()
        finally:
            folder = _folders().get(threading.get_ident())
            if folder is not None and any(Path(folder.name).glob("*.pch")):
                self._folder = folder
            self._is_tried.set()


def _folders() -> dict[int, TemporaryDirectory[str]]:
    """Warp's folders of headers by thread; one of nobody's where this Warp has no such thing.

    Threads then have headers of their own, and nothing else is different.
    """
    runtime: Any = getattr(getattr(getattr(wp, "_src", None), "context", None), "runtime", None)
    found = getattr(runtime, "_pch_dirs", None)
    return found if isinstance(found, dict) else {}
