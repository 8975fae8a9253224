"""The reading process is started on demand and asked for the contents of a file."""

from __future__ import annotations

import atexit
import json
import os
import select
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

from warp_softbody.body.mesh_formats.contents import Contents, ReadingFailed, unpack

BASE_SECONDS, BYTES_PER_SECOND = 1, 1e5
"""CPU time allowed for a file: meshio's slowest readers take some 1e6 bytes a second."""

BASE_MEMORY, MEMORY_PER_BYTE = 2**30, 100
"""Address space allowed for a file, bytes, of which the empty process takes a third."""

WAITING = 2.0
"""Wall time allowed over CPU time, because other processes share the processors."""

STARTING = 60.0
"""Wall time in which the process must be ready; it takes some 0.3 s."""

MAIN = "from warp_softbody.body.mesh_formats.server import main; main()"


class _Gone(Exception):
    """The reading process ended before it answered."""


class ReadingProcess:
    """A process that reads files for this one, kept for the next file.

    Attributes:
        waiting: s of wall time allowed over the CPU time that a file's size allows.
    """

    def __init__(self, waiting: float = WAITING) -> None:
        """Nothing is started yet."""
        self.waiting = waiting
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._inherited: list[subprocess.Popen[bytes]] = []

    @property
    def number(self) -> int | None:
        """Of the process; None where it does not run."""
        return None if self._process is None else self._process.pid

    def ask(self, question: dict[str, object], seconds: float) -> bytes:
        """The answer to a question, from a new process where the last one had just ended."""
        with self._lock:
            try:
                return self._exchange(question, seconds)
            except _Gone:
                return self._exchange(question, seconds)

    def _exchange(self, question: dict[str, object], seconds: float) -> bytes:
        starting = self._process is None
        process = self._process = self._process or _start()
        try:
            if starting:
                self._take(process, 1, time.monotonic() + STARTING)
            assert process.stdin is not None
            process.stdin.write(json.dumps(question).encode() + b"\n")
            process.stdin.flush()
            deadline = time.monotonic() + seconds
            (length,) = struct.unpack("<q", self._take(process, 8, deadline))
            return self._take(process, length, deadline)
        except BrokenPipeError as error:
            self.end()
            raise _Gone from error
        # After Ctrl-C too: an answer that nobody waits for would be taken for the next one.
        except BaseException:
            self.end()
            raise

    def _take(self, process: subprocess.Popen[bytes], count: int, deadline: float) -> bytes:
        assert process.stdout is not None
        parts: list[bytes] = []
        while count > 0:
            left = deadline - time.monotonic()
            if left <= 0.0 or not select.select([process.stdout], [], [], left)[0]:
                raise ReadingFailed("its reader did not finish in time")
            part = os.read(process.stdout.fileno(), count)
            if not part:
                raise _Gone
            parts.append(part)
            count -= len(part)
        return b"".join(parts)

    def end(self) -> None:
        """End the process, and with it the fork that reads."""
        process, self._process = self._process, None
        if process is None:
            return
        try:
            os.killpg(process.pid, 9)
        except ProcessLookupError:
            pass
        process.wait()
        for stream in (process.stdin, process.stdout):
            assert stream is not None
            try:
                stream.close()
            except BrokenPipeError:
                pass

    def forget(self) -> None:
        """Leave the process to the parent of this fork, and let it see when that one ends."""
        self._lock = threading.Lock()
        process, self._process = self._process, None
        if process is not None:
            assert process.stdin is not None and process.stdout is not None
            process.stdin.close()
            process.stdout.close()
            self._inherited.append(process)


READER = ReadingProcess()
"""That of this process."""
atexit.register(READER.end)
os.register_at_fork(after_in_child=READER.forget)


def _start() -> subprocess.Popen[bytes]:
    paths = os.pathsep.join(os.path.abspath(path) for path in sys.path)
    environment = {**os.environ, "PYTHONPATH": paths, "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.Popen(
        [sys.executable, "-c", MAIN],
        cwd="/",
        env=environment,
        bufsize=0,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def read_in_child(path: Path, file_format: str, reader: ReadingProcess = READER) -> Contents:
    """Contents of a tet file, read by meshio in a process with limits.

    Raises:
        ReadingFailed: the reason why there are none.
    """
    size = path.stat().st_size
    seconds = int(BASE_SECONDS + size / BYTES_PER_SECOND)
    question: dict[str, object] = {
        "path": os.path.abspath(path),
        "format": file_format,
        "seconds": seconds,
        "memory": BASE_MEMORY + MEMORY_PER_BYTE * size,
    }
    try:
        return unpack(reader.ask(question, seconds + reader.waiting))
    except _Gone as error:
        raise ReadingFailed("its reader could not be started") from error
