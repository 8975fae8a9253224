"""Every finished run on disk at once, so that a sweep that was stopped goes on where it was."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.outcome import Path3, RunOutcome
from warp_softbody.atomic_files import replacing, require_writable, sync_folder
from warp_softbody.errors import OutputError

_KEY = re.compile("[0-9a-f]{16}")
_DAMAGE = (ValueError, KeyError, TypeError, OSError, EOFError, MemoryError, RecursionError)
"""What damaged lines raise, and arrays that are missing, empty, folders, or not as they say."""
_COUNTS = ("tets", "nodes")
_NUMBERS = ("cost", "setup", "memory", "iterations", "passes", "qps", "unconverged")


class RunJournal:
    """A file of JSON lines, one a run, and beside it an array file for each run's path.

    A line is written after its array is on the disk, and in one piece. A line that was torn when
    the program was stopped, or whose run or array is not whole, is passed over: that run is made
    again.

    Attributes:
        outcomes: of the runs so far, by `Job.key`.
    """

    def __init__(self, folder: Path, scene: str) -> None:
        """Read what there is.

        Raises:
            OutputError: the folder cannot be made or written in, or the file cannot be read.
        """
        self._file = folder / f"{scene}.jsonl"
        self._paths = folder / scene
        self.outcomes: dict[str, RunOutcome] = {}
        try:
            self._paths.mkdir(parents=True, exist_ok=True)
            require_writable(self._paths)
            with self._file.open("ab"):
                pass
            text = self._file.read_bytes()
        except OSError as error:
            raise self._unwritten(error) from error
        self._torn = bool(text) and not text.endswith(b"\n")
        for line in text.splitlines():
            self._read(line)

    def _read(self, line: bytes) -> None:
        try:
            record = json.loads(line)
            key, values = record["key"], record["outcome"]
            if _KEY.fullmatch(key):
                path = _path(self._paths / f"{key}.npy")
                self.outcomes[key] = _outcome(values, path)
        except _DAMAGE:
            return

    def add(self, job: Job, outcome: RunOutcome) -> None:
        """Keep a finished run.

        Raises:
            OutputError: it cannot be written.
        """
        values = asdict(outcome)
        path = values.pop("path")
        record = json.dumps({"key": job.key, "job": job.to_dict(), "outcome": values})
        try:
            with replacing(self._paths / f"{job.key}.npy") as array:
                np.save(array, path)
            self._append((("\n" if self._torn else "") + record + "\n").encode())
        except OSError as error:
            self._torn = True
            raise self._unwritten(error) from error
        self._torn = False
        self.outcomes[job.key] = outcome

    def _append(self, line: bytes) -> None:
        """Add a line in one piece, so that those of another sweep stay whole."""
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC
        file = os.open(self._file, flags, 0o666)
        try:
            written = os.write(file, line)
            if written < len(line):
                raise OSError("the disk is full")
            os.fsync(file)
        finally:
            os.close(file)
        sync_folder(self._file.parent)

    def _unwritten(self, error: OSError) -> OutputError:
        return OutputError(
            f"cannot write into {str(self._file.parent)!r}: {error.strerror or error}"
        )


def _path(file: Path) -> Path3:
    """An array that is whole.

    Raises:
        ValueError: it is not what a run leaves.
    """
    found: Path3 = np.load(file, allow_pickle=False)
    if found.dtype != np.float32 or found.ndim != 3 or found.shape[2] != 3:
        raise ValueError(f"an array of {found.dtype} with the shape {found.shape}")
    return found


def _outcome(values: Mapping[str, Any], path: Path3) -> RunOutcome:
    """An outcome whose fields are what they must be.

    Raises:
        ValueError: one is not.
    """
    outcome = RunOutcome(**values, path=path)
    whole = [getattr(outcome, name) for name in _COUNTS]
    numbers = [*(getattr(outcome, name) for name in _NUMBERS), *whole]
    functionals = outcome.functionals
    good = (
        isinstance(outcome.status, str)
        and all(type(number) is int for number in whole)
        and all(_is_number(number) and number >= 0.0 for number in numbers)
        and isinstance(functionals, dict)
        and all(type(value) in (int, float) for value in functionals.values())
        and (not outcome.complete or (len(path) > 0 and bool(np.isfinite(path).all())))
    )
    if not good:
        raise ValueError("an outcome with a field of a wrong type")
    return outcome


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)
