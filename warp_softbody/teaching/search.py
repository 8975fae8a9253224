"""The search for gains: generations of tries in processes, kept in a journal as they come."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

from warp_softbody import __version__
from warp_softbody.arrays import FloatArray
from warp_softbody.body.lessons import Lesson
from warp_softbody.errors import InputError, OutputError
from warp_softbody.teaching.evolution import minimise
from warp_softbody.teaching.json_lines import JsonLines
from warp_softbody.teaching.task import Task
from warp_softbody.teaching.tries import Try, make_tries

RECORD = b'{"key": "'
"""What every line of a journal begins with."""


class Candidate(NamedTuple):
    """Gains and what came of them; the usual ones are number 0."""

    number: int
    lesson: Lesson
    tried: Try


@dataclass(frozen=True, kw_only=True)
class Search:
    """A search whose every step hangs on task, seed and tries alone.

    Attributes:
        task: what is to be learnt.
        executor: where tries are made.
        count: how many batches of them at once.
        journal: file of finished tries, which are not made again; None keeps none.
    """

    task: Task
    executor: Executor
    count: int = 1
    journal: Path | None = None

    def of(self, lesson: Lesson) -> Try:
        """What comes of gains; those of the journal are not tried again.

        Raises:
            InputError, OutputError: as `run`.
        """
        return self._tried({0: lesson}, _Kept(self.task, self.journal))[0]

    def run(self, draws: int, seed: int) -> Iterator[Candidate]:
        """So many candidates in their order, the first the usual gains; each as it is known.

        Raises:
            InputError: the journal is a file of another kind, or cannot be read.
            OutputError: it cannot be written.
        """
        field = self.task.field
        kept = _Kept(self.task, self.journal)
        found: dict[int, Candidate] = {}

        def costs(points: Mapping[int, FloatArray]) -> dict[int, float]:
            # the usual gains are no numbers of their own, so that they keep their last bit
            lessons = {n: field.numbers(point) if n else {} for n, point in points.items()}
            tried = self._tried(lessons, kept)
            for number, lesson in lessons.items():
                found[number] = Candidate(number, lesson, tried[number])
            return {number: own.cost for number, own in tried.items()}

        for one in minimise(costs, field.start, draws=draws, seed=seed):
            yield found[one.number]

    def _tried(self, lessons: Mapping[int, Lesson], kept: _Kept) -> dict[int, Try]:
        """What came of each lesson: what is known, and the rest in as many batches as may be."""
        known = {n: kept.of(lesson) for n, lesson in lessons.items()}
        waiting = [number for number, own in known.items() if own is None]
        size = -(-len(waiting) // self.count) or 1
        parts = [waiting[first : first + size] for first in range(0, len(waiting), size)]
        running = [
            self.executor.submit(make_tries, self.task, [lessons[n] for n in part])
            for part in parts
        ]
        for part, future in zip(parts, running, strict=True):
            for number, own in zip(part, future.result(), strict=True):
                kept.add(lessons[number], own)
                known[number] = own
        return {number: own for number, own in known.items() if own is not None}


def require_journal(path: Path) -> None:
    """Refuse a file that is there and is no journal of tries; an empty one may become one.

    Raises:
        InputError: it is of another kind, or cannot be read.
    """
    try:
        if not path.exists():
            return
        first = b""
        if path.is_file():
            with path.open("rb") as file:
                first = file.readline(len(RECORD)).rstrip(b"\n")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    # the first line may have been torn
    if not path.is_file() or not RECORD.startswith(first):
        raise InputError(f"{path}: it is no journal of teaching, so that no tries are added to it")


class _Kept:
    """Tries by what they hang on: body, motion, grounds, times and gains."""

    def __init__(self, task: Task, path: Path | None) -> None:
        if path is not None:
            require_journal(path)
        self._path, self._file = path, JsonLines(path)
        self._task = _fingerprint(task)
        self._tries: dict[str, Try] = {}
        for record in self._file.records:
            try:
                self._tries[record["key"]] = Try(*(float(x) for x in record["tried"]))
            except (KeyError, TypeError, ValueError):
                # a line of something else
                continue

    def of(self, lesson: Lesson) -> Try | None:
        """What is known of a lesson."""
        return self._tries.get(self._key(lesson))

    def add(self, lesson: Lesson, tried: Try) -> None:
        """Keep a try, on disk at once."""
        key = self._key(lesson)
        self._tries[key] = tried
        try:
            self._file.add({"key": key, "tried": list(tried), "gains": dict(lesson)})
        except OSError as error:
            raise OutputError(
                f"{self._path}: cannot be written: {error.strerror or error}"
            ) from error

    def _key(self, lesson: Lesson) -> str:
        text = self._task + json.dumps(dict(lesson), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _fingerprint(task: Task) -> str:
    """The same for the same task by the same version of the program."""
    body, found = task.character, hashlib.sha256()
    found.update(body.mesh.points.tobytes() + body.mesh.tets.tobytes())
    for fiber in body.fibers:
        found.update(fiber.vertices.tobytes())
    for name, nodes in sorted(body.regions.items()):
        found.update(name.encode() + nodes.tobytes())
    values = [
        *(asdict(body.material), [(own.strength, own.kernel_width) for own in body.muscles]),
        *(task.do, task.seconds, task.time_step, task.frictions, repr(task.usual), __version__),
    ]
    found.update(json.dumps(values).encode())
    return found.hexdigest()
