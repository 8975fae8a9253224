"""Journals that were damaged: what is whole is kept, the rest is run again."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.journal import RunJournal
from warp_softbody.accuracy.runs.outcome import RunOutcome, refused
from warp_softbody.errors import OutputError


def job(step: float) -> Job:
    return Job(
        scene="cantilever", seconds=0.2, functionals=("a",), settings=Settings(time_step=step)
    )


def outcome(cost: float) -> RunOutcome:
    return RunOutcome(
        status="complete",
        cost=cost,
        setup=0.1,
        memory=1.0,
        tets=6,
        nodes=8,
        iterations=3.5,
        passes=1.0,
        qps=0.0,
        unconverged=0.0,
        functionals={"a": 0.3},
        path=np.full((7, 4, 3), cost, dtype=np.float32),
    )


JOBS = [job(1.0 / 30.0), job(1.0 / 60.0), job(1.0 / 120.0)]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A journal of three runs, the last of which was refused."""
    journal = RunJournal(tmp_path, "cantilever")
    for number, one in enumerate(JOBS[:2]):
        journal.add(one, outcome(1.0 + number))
    journal.add(JOBS[2], refused("no such combination"))
    return tmp_path


def kept(folder: Path) -> list[str]:
    return list(RunJournal(folder, "cantilever").outcomes)


def test_runs_are_found_again(folder: Path) -> None:
    found = RunJournal(folder, "cantilever").outcomes
    assert list(found) == [one.key for one in JOBS]
    np.testing.assert_array_equal(found[JOBS[1].key].path, outcome(2.0).path)
    assert found[JOBS[2].key].status == "no such combination"
    assert sorted(path.name for path in folder.iterdir()) == ["cantilever", "cantilever.jsonl"]
    assert len(list((folder / "cantilever").iterdir())) == 3


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-5])


def _huge(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data.replace(b"(7, 4, 3)", b"(7000000000000, 4, 3)")[: len(data)])


def _not_finite(path: Path) -> None:
    np.save(path, np.full((7, 4, 3), np.nan, dtype=np.float32))


def _folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize(
    "damage",
    [
        Path.unlink,
        _cut,
        _huge,
        _not_finite,
        _folder,
        lambda path: path.write_bytes(b""),
        lambda path: path.write_bytes(b"\x93NUMPY"),
        lambda path: path.write_bytes(bytes(400)),
        lambda path: np.save(path, np.zeros((7, 4), dtype=np.float32)),
        lambda path: np.save(path, np.zeros((7, 4, 3))),
        lambda path: np.save(path, np.array([{"a": 1}], dtype=object)),
    ],
)
def test_a_damaged_array_is_run_again(folder: Path, damage: Callable[[Path], None]) -> None:
    damage(folder / "cantilever" / f"{JOBS[0].key}.npy")
    assert kept(folder) == [JOBS[1].key, JOBS[2].key]


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"\xff\xfe\x00",
        b"{",
        b"[]",
        b"3",
        b'"text"',
        b"null",
        b"{}",
        b"[" * 5000,
        b'{"key": 3, "outcome": {}}',
        b'{"key": "../../etc/passwd", "outcome": {}}',
    ],
)
def test_a_damaged_line_is_passed_over(folder: Path, line: bytes) -> None:
    file = folder / "cantilever.jsonl"
    lines = file.read_bytes().splitlines()
    file.write_bytes(b"\n".join([lines[0], line, lines[2]]))
    assert kept(folder) == [JOBS[0].key, JOBS[2].key]
    # and what is added after a line that was torn has one of its own
    RunJournal(folder, "cantilever").add(JOBS[1], outcome(2.0))
    assert len(kept(folder)) == 3


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("status", 3),
        ("cost", "much"),
        ("cost", -1.0),
        ("cost", None),
        ("tets", 6.5),
        ("tets", True),
        ("functionals", [1.0]),
        ("functionals", {"a": "b"}),
        ("unknown", 1.0),
    ],
)
def test_a_field_that_cannot_be_one_is_run_again(folder: Path, field: str, value: Any) -> None:
    file = folder / "cantilever.jsonl"
    lines = file.read_text().splitlines()
    record = json.loads(lines[0])
    record["outcome"][field] = value
    file.write_text("\n".join([json.dumps(record), *lines[1:]]) + "\n")
    assert kept(folder) == [JOBS[1].key, JOBS[2].key]


def test_an_array_is_on_the_disk_before_its_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    write = os.write

    def first_look(file: int, line: bytes) -> int:
        order.extend(path.name for path in (tmp_path / "cantilever").iterdir())
        return write(file, line)

    monkeypatch.setattr(os, "write", first_look)
    RunJournal(tmp_path, "cantilever").add(JOBS[0], outcome(1.0))
    assert order == [f"{JOBS[0].key}.npy"]


def test_a_full_disk_is_one_sentence(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was written of the line is passed over, and the next one has a line of its own."""
    write = os.write
    journal = RunJournal(folder, "cantilever")
    monkeypatch.setattr(os, "write", lambda file, line: write(file, line[:50]))
    with pytest.raises(OutputError, match="the disk is full"):
        journal.add(job(1.0 / 240.0), outcome(4.0))
    monkeypatch.undo()
    assert len(kept(folder)) == 3
    journal.add(job(1.0 / 240.0), outcome(4.0))
    assert len(kept(folder)) == 4


def test_a_journal_that_cannot_be_kept_is_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "cantilever.jsonl").mkdir()
    for folder in (tmp_path / "file", tmp_path / "file" / "below", tmp_path, Path("/proc/self")):
        with pytest.raises(OutputError, match="cannot write into"):
            RunJournal(folder, "cantilever")
