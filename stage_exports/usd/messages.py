"""Messages between two processes, one of which is a fork of the other.

`multiprocessing.Pipe` does the same, and takes longer to load than it has work here.
"""

from __future__ import annotations

import pickle
import select
import socket
import struct
from typing import Any

_SIZE = struct.Struct("<Q")


class Messages:
    """One end of a connection, which objects that can be pickled go through whole and in order."""

    def __init__(self, ours: socket.socket) -> None:
        """Take one of two sockets that are connected."""
        self._socket = ours
        self._waiting = select.poll()
        self._waiting.register(ours, select.POLLIN)

    @classmethod
    def pair(cls) -> tuple[Messages, Messages]:
        """Both ends."""
        one, other = socket.socketpair()
        return cls(one), cls(other)

    def send(self, message: object) -> None:
        """Hand an object over; this waits while much is on its way.

        Raises:
            BrokenPipeError: the other end is closed.
            ConnectionResetError: the same.
        """
        data = pickle.dumps(message)
        self._socket.sendall(_SIZE.pack(len(data)) + data)

    def receive(self) -> Any:
        """The next object; this waits for it.

        Raises:
            EOFError: the other end is closed.
            ConnectionResetError: the same, and it had not read all.
        """
        return pickle.loads(self._bytes(*_SIZE.unpack(self._bytes(_SIZE.size))))

    def has_any(self) -> bool:
        """Whether an object, or the end, waits to be received."""
        return bool(self._waiting.poll(0))

    def close(self) -> None:
        """End the connection."""
        self._socket.close()

    def _bytes(self, count: int) -> bytes:
        parts, missing = [], count
        while missing:
            part = self._socket.recv(min(missing, 1 << 20))
            if not part:
                raise EOFError
            parts.append(part)
            missing -= len(part)
        return b"".join(parts)
