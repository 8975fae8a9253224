"""A body learns: ranges, tries, the search and its journal, and what its file keeps."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import ParamSpec, TypeVar

import numpy as np
import pytest

from tests.support.surfaces import BODIES
from warp_softbody import Character, characters, scenes
from warp_softbody.body.lessons import read_lessons, write_lesson
from warp_softbody.cli import main, teach_command
from warp_softbody.cli.interruption import Interrupted
from warp_softbody.controllers import StepGains
from warp_softbody.controllers.motions.for_any_body.taught import number_at, with_numbers
from warp_softbody.controllers.motions.jump_gains import JumpGains
from warp_softbody.errors import InputError, MeshWarning
from warp_softbody.teaching import search as searching
from warp_softbody.teaching.ranges import WANTED, Field, Range
from warp_softbody.teaching.search import Search
from warp_softbody.teaching.task import Task
from warp_softbody.teaching.tries import Try, make_tries

P = ParamSpec("P")
T = TypeVar("T")


class AtOnce(Executor):
    """Makes every call when it is handed in."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return what is done already."""
        done: Future[T] = Future()
        done.set_result(fn(*args, **kwargs))
        return done


@pytest.fixture(scope="module")
def worm() -> Character:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return Character.from_surface(BODIES["caterpillar"](), name="worm", tets=300)


def quick(worm: Character, seconds: float = 0.5) -> Task:
    return Task(character=worm, do="crawl", seconds=seconds, frictions=(0.8,))


def test_ranges() -> None:
    even, by_logarithm = Range(-1.0, 3.0), Range(0.5, 8.0, log=True)
    assert (even.number(0.25), even.share(0.0)) == (0.0, 0.25)
    assert by_logarithm.number(0.5) == pytest.approx(2.0)
    assert by_logarithm.share(2.0) == pytest.approx(0.5)
    assert even.share(9.0) == 1.0


@pytest.mark.parametrize("do", WANTED)
def test_the_usual_gains_are_within_their_ranges(do: str, worm: Character) -> None:
    body = worm if do == "crawl" else characters.letter_i(coarse=1)
    if do == "roll":
        body = replace(body, regions={**body.regions, "rim": body.region("base")})
    task = Task(character=body, do=do)
    field = task.field
    assert len(field.ranges) > 10
    for path, number in field.numbers(field.start).items():
        assert number == pytest.approx(number_at(task.usual, path), abs=1e-12), path
    # every corner of the cube is one that the gains take
    for corner in (np.zeros(len(field.ranges)), np.ones(len(field.ranges))):
        task.controller(field.numbers(corner))


def test_numbers_by_their_paths() -> None:
    gains = with_numbers(StepGains(), {"stride": 0.2, "activation.effort": 0.3})
    assert (gains.stride, gains.activation.effort) == (0.2, 0.3)
    assert with_numbers(JumpGains(), {"launch.0": 0.1}).launch == (0.1, 0.0, 0.38)
    for path in ("strid", "launch.3", "launch.x", "activation.effort.0"):
        with pytest.raises(InputError, match=r"there is no gain"):
            with_numbers(JumpGains(), {path: 1.0})
    with pytest.raises(InputError, match=r"StepGains.stand"):
        with_numbers(StepGains(), {"stand": 7.0})


def test_what_a_zero_is_has_no_range_around_it() -> None:
    assert "lift" not in Field(StepGains(lift=0.0), {"lift": (2.0, None)}).ranges


def test_tries_tell_who_goes_further(worm: Character) -> None:
    usual, still = make_tries(quick(worm, 1.5), [{}, {"stride": 1e-6}])
    assert usual.way > still.way + 0.02
    assert usual.cost < still.cost
    assert usual.lasted == still.lasted == 1.0


def test_a_fall_costs_more_than_standing_still() -> None:
    letter = characters.letter_i(coarse=1)
    narrow = replace(letter, material=replace(letter.material, young_modulus=2e4))
    (tried,) = make_tries(Task(character=narrow, do="walk", seconds=1.0), [{}])
    assert tried.fell
    assert tried.cost > Try(0.0, 0.0, 1.0).cost + 0.25


def test_costs() -> None:
    still, late, soon = Try(0.0, 0.0, 1.0), Try(2.5, 0.0, 0.6), Try(0.5, 0.0, 0.2)
    assert still.cost == 0.0
    assert Try(1.0, 0.5, 1.0).cost == -0.75
    assert late.cost == pytest.approx(0.25 + 0.8 - 2.5)
    assert late.cost < still.cost < soon.cost


def test_a_search_goes_on_where_it_was(
    worm: Character, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same seed gives the same candidates, and what is in the journal is not tried again."""
    made: list[int] = []

    def tries(task: Task, lessons: list[dict[str, float]]) -> list[Try]:
        made.append(len(lessons))
        ways = [1.0 - abs(own.get("stride", 0.16) - 0.3) for own in lessons]
        return [Try(way, 0.0, 1.0) for way in ways]

    monkeypatch.setattr(searching, "make_tries", tries)
    journal = tmp_path / "worm.jsonl"
    search = Search(task=quick(worm), executor=AtOnce(), count=2, journal=journal)
    whole = list(search.run(20, seed=3))
    assert sum(made) == 20
    assert whole[0].lesson == {}
    best = min(whole, key=lambda one: one.tried.cost)
    assert abs(best.lesson["stride"] - 0.3) < 0.1
    lines = journal.read_bytes().splitlines(keepends=True)
    # a journal that was torn in the middle of a line
    journal.write_bytes(b"".join(lines[:8]) + lines[8][:20])
    made.clear()
    assert list(search.run(20, seed=3)) == whole
    assert sum(made) == 12
    assert list(search.run(20, seed=4)) != whole


def test_a_task_is_told_apart_in_the_journal(worm: Character) -> None:
    names = {
        searching._fingerprint(own)
        for own in (
            quick(worm),
            quick(worm, 2.0),
            replace(quick(worm), do="walk"),
            replace(quick(worm), character=replace(worm, name="other")),
            replace(
                quick(worm),
                character=replace(worm, material=replace(worm.material, young_modulus=1e6)),
            ),
        )
    }
    # a name is nothing that a body moves by
    assert len(names) == 4


def test_a_file_keeps_lessons(worm: Character, tmp_path: Path) -> None:
    path = tmp_path / "worm.char"
    worm.save(path)
    before = Character.load(path)
    assert read_lessons(path) == {}
    write_lesson(path, "crawl", {"stride": 0.21})
    write_lesson(path, "walk", {"activation.effort": 0.4})
    write_lesson(path, "crawl", {"stride": 0.22})
    assert read_lessons(path) == {"crawl": {"stride": 0.22}, "walk": {"activation.effort": 0.4}}
    assert Character.load(path) == before
    plan = scenes.make(str(path), do="crawl")
    assert plan.controller._gains.stride == 0.22  # type: ignore[union-attr]
    with pytest.raises(InputError, match="there is no such file"):
        write_lesson(tmp_path / "none.char", "walk", {})


def test_the_command_teaches(
    worm: Character, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "worm.char"
    worm.save(path)
    line = ["teach", str(path), "--do", "crawl", "--draws", "3", "--seconds", "0.3"]
    assert main([*line, "--workers", "1", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["tried"] == 3
    assert facts["kept"] == bool(read_lessons(path))
    assert len((tmp_path / "worm.crawl.jsonl").read_text().splitlines()) == 3
    # all of it is in the journal now
    assert main([*line, "--workers", "1"]) == 0
    said = capsys.readouterr()
    assert "3 gains tried for --do crawl" in said.out
    assert said.err == ""


def test_a_body_saved_over_its_file_keeps_its_lessons(worm: Character, tmp_path: Path) -> None:
    path = tmp_path / "worm.char"
    worm.save(path)
    write_lesson(path, "crawl", {"stride": 0.21})
    taught = path.read_bytes()
    Character.load(path).save(path)
    assert path.read_bytes() == taught
    # what it looks like is nothing that it has learnt by
    replace(worm, name="other", color=(0.1, 0.2, 0.3), skin=None).save(path)
    assert read_lessons(path) == {"crawl": {"stride": 0.21}}
    softer = replace(worm, material=replace(worm.material, young_modulus=1.5e4))
    softer.save(path)
    assert read_lessons(path) == {}


def stubbed(monkeypatch: pytest.MonkeyPatch, best: float, after: Callable[[], None]) -> None:
    """Tries that go far by how near their stride is to the best, with something after each."""

    def tries(task: Task, lessons: list[dict[str, float]]) -> list[Try]:
        after()
        return [Try(1.0 - abs(own.get("stride", 0.16) - best), 0.0, 1.0) for own in lessons]

    monkeypatch.setattr(searching, "make_tries", tries)
    monkeypatch.setattr("warp_softbody.accuracy.runs.workers.workers", lambda _: AtOnce())


def nothing() -> None:
    """Happens."""


def test_better_gains_of_the_file_stay(
    worm: Character,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stubbed(monkeypatch, 0.3, nothing)
    path = tmp_path / "worm.char"
    worm.save(path)
    write_lesson(path, "crawl", {"stride": 0.3})
    line = ["teach", str(path), "--do", "crawl", "--draws", "20"]
    assert main([*line, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["held_way"], facts["way"], facts["kept"]) == (1.0, 1.0, False)
    assert facts["gains"] == {"stride": 0.3}
    assert main([*line, "--quiet"]) == main(line) == 0
    assert "nothing better; " in capsys.readouterr().out
    assert read_lessons(path) == {"crawl": {"stride": 0.3}}
    # gains that are worse, and those that the motion does not know, are replaced
    for held in ({"stride": 0.05}, {"strid": 0.3}):
        write_lesson(path, "crawl", held)
        assert main(line) == 0
        assert "kept in" in capsys.readouterr().out
        assert abs(read_lessons(path)["crawl"]["stride"] - 0.3) < 0.1


def test_a_body_that_was_not_taught_gets_no_gains(
    worm: Character,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "worm.char"
    worm.save(path)
    softer = replace(worm, material=replace(worm.material, young_modulus=1.5e4))
    stubbed(monkeypatch, 0.3, lambda: softer.save(path))
    assert main(["teach", str(path), "--do", "crawl", "--draws", "20"]) == 2
    assert "another body than the one that was taught" in capsys.readouterr().err
    assert read_lessons(path) == {}


def test_journals_that_cannot_be_used_are_told(
    worm: Character,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path, other = tmp_path / "worm.char", tmp_path / "other.obj"
    worm.save(path)
    other.write_text("v 0 0 0\n")
    line = ["teach", str(path), "--do", "crawl", "--draws", "2", "--journal"]
    for file in (path, other, tmp_path):
        before = file.read_bytes() if file.is_file() else b""
        assert main([*line, str(file)]) == 2
        assert capsys.readouterr().err.count("it is no journal of teaching") == 1
        assert not before or file.read_bytes() == before
    assert main([*line, str(tmp_path / "none" / "c.jsonl")]) == 2
    assert "none: cannot be written in: No such file" in capsys.readouterr().err
    gone = tmp_path / "gone"
    gone.mkdir()
    stubbed(monkeypatch, 0.3, gone.rmdir)
    assert main([*line, str(gone / "c.jsonl")]) == 2
    assert "c.jsonl: cannot be written: No such file" in capsys.readouterr().err


@pytest.mark.parametrize("text", [b"", b'{"k', b'{"key": "cf', b'{"k\n{"key": "cf'])
def test_torn_journals_are_journals(text: bytes, tmp_path: Path) -> None:
    journal = tmp_path / "c.jsonl"
    journal.write_bytes(text)
    searching.require_journal(journal)


def test_mistakes_are_told(
    worm: Character, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "worm.char"
    worm.save(path)
    assert main(["teach", str(path), "--do", "hop"]) == 2
    assert "Jump needs a body that stands" in capsys.readouterr().err
    assert main(["teach", str(path), "--do", "fly"]) == 2
    assert main(["teach", str(tmp_path / "no.char"), "--do", "walk"]) == 2
    assert "there is no such file" in capsys.readouterr().err


def test_a_search_that_is_stopped_says_where_it_goes_on(
    worm: Character,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def stopped(*_: object) -> None:
        raise Interrupted(2)

    monkeypatch.setattr(teach_command, "_search", stopped)
    path = tmp_path / "worm.char"
    worm.save(path)
    assert main(["teach", str(path), "--do", "crawl"]) == 130
    assert "interrupted before the first try ended" in capsys.readouterr().err
    (tmp_path / "worm.crawl.jsonl").write_text('{"key": "a"}\n')
    assert main(["teach", str(path), "--do", "crawl"]) == 130
    assert "the same command goes on there" in capsys.readouterr().err
    assert read_lessons(path) == {}
