"""Memory that a process shares with its fork, in which messages stand one behind the other."""

from __future__ import annotations

import mmap
from collections import deque
from contextlib import suppress

POPULATE_WRITE = 23
"""Of `madvise` since Linux 5.14; Python 3.11 has no name for it."""


class ByteRing:
    """Who writes puts messages in; who reads is told their places and says when it has read them.

    The two halves hold one such object each after the fork; only the memory itself is shared.
    """

    def __init__(self, size: int) -> None:
        """Ask for memory of so many bytes, which is there with its first use or `settle`."""
        self.size = size
        self._memory = mmap.mmap(-1, size, flags=mmap.MAP_SHARED | mmap.MAP_ANONYMOUS)
        self._head = 0
        self._unread: deque[tuple[int, int]] = deque()

    def settle(self) -> None:
        """Take all memory at once: page after page it costs more than the messages.

        The half that does so first has it filled with zeros; the other one is quick then.
        """
        with suppress(OSError, ValueError):
            self._memory.madvise(POPULATE_WRITE)

    def put(self, message: bytes) -> int | None:
        """Write a message; returns its place, or None where there is no room for it now."""
        place = self._room(len(message))
        if place is None:
            return None
        self._memory[place : place + len(message)] = message
        self._unread.append((place, place + len(message)))
        self._head = place + len(message)
        return place

    def let_go(self, count: int) -> None:
        """The first messages that are still there have been read, so many of them."""
        for _ in range(count):
            self._unread.popleft()

    def view(self, place: int, size: int) -> memoryview:
        """A message, as long as its writer has not been told that it was read."""
        return memoryview(self._memory)[place : place + size]

    def _room(self, wanted: int) -> int | None:
        if not self._unread:
            return 0 if wanted <= self.size else None
        tail = self._unread[0][0]
        if self._head < tail:
            return self._head if wanted < tail - self._head else None
        if wanted <= self.size - self._head:
            return self._head
        return 0 if wanted < tail else None
