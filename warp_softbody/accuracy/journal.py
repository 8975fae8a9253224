"""Every finished run on disk at once, so that a sweep that was stopped goes on where it was."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from pathlib import Path

import numpy as np

from warp_softbody.accuracy.running import Job, Outcome
from warp_softbody.errors import OutputError


class Journal:
    """A file of JSON lines, one a run, and beside it an array file for each run's path.

    A line is written after its array, and in one piece; a line that was torn when the program was
    stopped is passed over.

    Attributes:
        outcomes: of the runs so far, by `Job.key`.
    """

    def __init__(self, folder: Path, scene: str) -> None:
        """Read what there is.

        Raises:
            OutputError: the folder cannot be made.
        """
        self._file = folder / f"{scene}.jsonl"
        self._paths = folder / scene
        try:
            self._paths.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"cannot write into {str(folder)!r}: {error.strerror}") from error
        self.outcomes: dict[str, Outcome] = {}
        text = self._file.read_text() if self._file.exists() else ""
        self._torn = bool(text) and not text.endswith("\n")
        for line in text.splitlines():
            self._read(line)

    def _read(self, line: str) -> None:
        try:
            record = json.loads(line)
            key, values = record["key"], record["outcome"]
            path = np.load(self._paths / f"{key}.npy")
            self.outcomes[key] = Outcome(**values, path=path)
        except (ValueError, KeyError, TypeError, OSError):
            return

    def add(self, job: Job, outcome: Outcome) -> None:
        """Keep a finished run."""
        values = asdict(outcome)
        np.save(self._paths / f"{job.key}.npy", values.pop("path"))
        record = json.dumps({"key": job.key, "job": job.to_dict(), "outcome": values})
        with self._file.open("a") as file:
            file.write(("\n" if self._torn else "") + record + "\n")
            file.flush()
            os.fsync(file.fileno())
        self._torn = False
        self.outcomes[job.key] = outcome
