"""Stages from elsewhere are opened in a process of their own, with limits of time and memory.

USD maps files into memory and trusts them: one that is damaged can end the process or keep it busy
for ever. The child hands back arrays; what ends it is one sentence here. Files that this process
has just written are read here.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from warp_softbody.errors import InputError
from warp_softbody.inputs import input_kinds
from warp_softbody.stage_exports.usd.stage_files import is_own
from warp_softbody.stage_exports.usd.watchdog import ENDINGS

TASKS = {
    "extract": "extraction",
    "extract_names": "extraction",
    "extract_skin": "foreign_skins",
    "find_faults": "faults",
    "merge": "merging",
    "rewrite": "merging",
}
"""Functions and their modules in this package; they take and return plain values and arrays."""

SECONDS, SECONDS_A_BYTE = 5.0, 2e-7
"""CPU time without progress (`watchdog.py`)."""
MEMORY, MEMORY_A_BYTE = 8 << 30, 40
"""Bytes of address space."""


def apart(
    task: str,
    file: str | Path,
    *arguments: Any,
    size: int = 0,
    trusted: bool = False,
    seconds: float = SECONDS,
) -> Any:
    """The result of a task on a file, wherever it is run.

    Args:
        task: a key of ``TASKS``.
        file: what is read; the first argument of the task.
        arguments: the others.
        size: bytes read, where they are not those of the file.
        trusted: whether this process has written what is read.
        seconds: CPU time without progress after which the child is ended, beside what the file's
            size asks for.

    Raises:
        InputError: what the task refuses, or that the file ends or keeps the process that reads it.
        OSError: what the task writes could not be written.
    """
    file = input_kinds.path("path of a stage", file)
    if trusted or is_own(Path(file)) or not Path(file).exists():
        return guarded(task, str(file), *arguments)
    size = size or _size(Path(file))
    limits = {
        "seconds": seconds + SECONDS_A_BYTE * size,
        "memory": int(MEMORY + MEMORY_A_BYTE * size),
    }
    order = json.dumps({"task": task, "arguments": [os.fspath(file), *arguments], **limits})
    code, answer = _run(order)
    if code != 0 or not answer:
        raise InputError(f"{str(file)!r} cannot be read: {_ending(code)}")
    ending, result = pickle.loads(answer)
    if ending == "refused":
        raise InputError(result)
    if ending == "failed":
        raise OSError(result)
    return result


def guarded(task: str, file: str, *arguments: Any) -> Any:
    """Run a task here; what USD raises about a damaged file becomes an InputError."""
    from pxr import Tf

    try:
        return _function(task)(file, *arguments)
    except InputError:
        raise
    except Tf.ErrorException as error:
        cause = str(error.args[0].commentary) if error.args else str(error)
        raise InputError(f"{file!r} is damaged: {_line(cause)}") from error
    except (
        ArithmeticError,
        LookupError,
        MemoryError,
        RuntimeError,
        TypeError,
        ValueError,
    ) as error:
        raise InputError(f"{file!r} is damaged: {_line(str(error))}") from error


def _function(task: str) -> Callable[..., Any]:
    home = import_module(f"warp_softbody.stage_exports.usd.{TASKS[task]}")
    found: Callable[..., Any] = getattr(home, task)
    return found


def _run(order: str) -> tuple[int, bytes]:
    """Exit status and answer of a child, which is gone afterwards."""
    paths = os.pathsep.join(os.path.abspath(path) for path in sys.path)
    process = subprocess.Popen(
        [sys.executable, "-m", "warp_softbody.stage_exports.usd.child", order],
        env={**os.environ, "PYTHONPATH": paths, "PXR_WORK_THREAD_LIMIT": "1"},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    try:
        answer, _ = process.communicate()
    finally:
        process.kill()
        process.wait()
    return process.returncode, answer


def _ending(code: int) -> str:
    if -code in ENDINGS:
        return "reading it takes longer than a file of its size may"
    if code < 0:
        return f"it is damaged so that USD ends with {signal.Signals(-code).name}"
    return "it is damaged so that USD ends, or needs too much memory"


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _line(text: str) -> str:
    """One line, whatever USD has to say."""
    return " ".join(text.split()) or "USD cannot unpack it"
