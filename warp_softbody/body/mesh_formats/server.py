"""The process in which tet files are read, one fork for each file.

It has meshio loaded, so that a file costs milliseconds. A fork has limits of its own, and whatever
happens to it, such as a crash, an endless loop or a demand for all memory, is one answer.
"""

from __future__ import annotations

import json
import os
import resource
import select
import signal
import struct
import sys
from importlib import import_module
from pathlib import Path

from warp_softbody.body.mesh_formats.contents import ReadingFailed, pack
from warp_softbody.body.mesh_formats.meshio_reader import read_by_meshio

IDLE = 10.0
"""s without a question, after which the process ends."""


def main() -> None:
    """Say that it is ready, then answer questions, a line of JSON each.

    It ends when the one who asks is gone or silent.
    """
    import_module("meshio")  # once, for all forks

    answers = os.dup(1)
    silence = os.open(os.devnull, os.O_RDWR)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    os.write(answers, b"!")
    while select.select([0], [], [], IDLE)[0]:
        question = sys.stdin.readline()
        if not question:
            break
        answer = _answer(json.loads(question))
        with os.fdopen(os.dup(answers), "wb") as stream:
            stream.write(struct.pack("<q", len(answer)) + answer)


def _answer(question: dict[str, object]) -> bytes:
    """What a fork says of one file, or how it ended."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reading)
            with os.fdopen(writing, "wb") as stream:
                stream.write(_read(question))
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as stream:
        data = stream.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if status == -signal.SIGXCPU or status == -signal.SIGKILL:
        return pack(f"its reader did not finish in {question['seconds']} s")
    if status != 0 or not data:
        name = signal.Signals(-status).name if status < 0 else f"status {status}"
        return pack(f"its reader ended with {name}")
    return data


def _read(question: dict[str, object]) -> bytes:
    """Read within the limits of the question."""
    seconds, memory = int(str(question["seconds"])), int(str(question["memory"]))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        return pack(read_by_meshio(Path(str(question["path"])), str(question["format"])))
    except ReadingFailed as error:
        return pack(str(error))
    except OSError as error:
        return pack(f"{error.filename or question['path']}: {error.strerror or error}")
    except MemoryError:
        return pack("it asks for more memory than a file of its size may")
    except Exception as error:
        return pack(f"what was read is no mesh ({type(error).__name__}: {error})"[:200])
