"""`warp-softbody teach NAME.char --do walk` searches gains with which a body goes further."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.arguments import number, whole
from warp_softbody.cli.interruption import Interrupted, held_back
from warp_softbody.cli.output import say
from warp_softbody.cli.progress import CountBar
from warp_softbody.errors import InputError, OutputError
from warp_softbody.inputs.extras import require_package

if TYPE_CHECKING:
    from warp_softbody.teaching.search import Candidate
    from warp_softbody.teaching.task import Task
    from warp_softbody.teaching.tries import Try

BETTER, TRAVELS = 0.02, 0.1
"""Body lengths by which a try has to cost less than that of the usual gains, and has to come, to be
kept: a body that learns to stand has not learnt to walk."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Of a search.

    Attributes:
        usual: the usual gains and what came of them.
        found: the best, which may be the usual ones or those that the file held.
        held: what came of the gains that the file held; None where it held none.
        tried: how many gains.
    """

    usual: Candidate
    found: Candidate
    held: Try | None
    tried: int

    @property
    def better(self) -> bool:
        """Whether what was found goes into the file."""
        own = self.found.tried
        beats = own.cost < self.usual.tried.cost - BETTER and own.way >= TRAVELS
        return beats and (self.held is None or own.cost < self.held.cost)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "teach",
        help="search gains with which a character goes further",
        description="Search the gains of a motion by evolution (CMA-ES), each candidate tried on "
        "two grounds, and keep the best in the character's file, where `run NAME.char --do` finds "
        "them. What has been tried is in a journal, so that a search that was stopped goes on.",
    )
    parser.add_argument("character", metavar="NAME.char", type=Path, help="file of the character")
    parser.add_argument(
        "--do", choices=("walk", "crawl", "hop", "roll"), required=True, help="what it is to learn"
    )
    parser.add_argument("--draws", type=whole(2, 100_000), default=100, help="candidates (100)")
    parser.add_argument("--seed", type=whole(0, 2**31 - 1), default=0, help="of the search (0)")
    parser.add_argument(
        "--seconds", metavar="S", type=number(0.1, 1e3, "s"), default=8.0, help="of a try (8)"
    )
    parser.add_argument(
        "--workers", type=whole(1, 1024), help="processes (as many as there are cores)"
    )
    parser.add_argument(
        "--journal", metavar="F.jsonl", type=Path, help="of tries (NAME.DO.jsonl beside the file)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Search, keep the best, and tell what it does; return 0.

    Raises:
        SoftBodyError: the file is no character's or gets another body meanwhile, the body cannot
            do it, the journal is of another kind or cannot be written, or cmaes is missing.
        Interrupted: by a signal; what was tried is kept.
    """
    require_package("cmaes", "searches", "teach")
    with held_back():
        from warp_softbody.body.character import Character
        from warp_softbody.body.lessons import read_body, read_lessons, write_lesson
        from warp_softbody.teaching.search import require_journal
        from warp_softbody.teaching.task import Task

    body = read_body(args.character)
    task = Task(character=Character.load(args.character), do=args.do, seconds=args.seconds)
    held = _fitting(task, read_lessons(args.character).get(args.do))
    folder = args.character.parent
    journal = args.journal or folder / f"{args.character.stem}.{args.do}.jsonl"
    _require_writable(folder)
    _require_writable(journal.parent)
    require_journal(journal)
    try:
        outcome = _search(args, task, journal, held)
    except Interrupted as interrupted:
        interrupted.left = (
            f"; what was tried is in {journal}, and the same command goes on there"
            if journal.exists()
            else " before the first try ended"
        )
        raise
    if outcome.better:
        write_lesson(args.character, args.do, outcome.found.lesson, body)
    facts = _facts(args, outcome, held)
    if args.json:
        say(json.dumps(facts))
    elif not args.quiet:
        say(_as_text(args, facts))
    return 0


def _fitting(task: Task, lesson: Mapping[str, float] | None) -> Mapping[str, float] | None:
    """A lesson that the motion still takes; None where it does not, so that it is replaced."""
    try:
        task.controller(lesson or {})
    except InputError:
        return None
    return lesson


def _require_writable(folder: Path) -> None:
    from warp_softbody.atomic_files import require_writable

    try:
        require_writable(folder)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written in: {error.strerror or error}") from error


def _search(
    args: argparse.Namespace, task: Task, journal: Path, held: Mapping[str, float] | None
) -> Outcome:
    """The best of all candidates, beside the usual gains and those that the file holds."""
    from warp_softbody.accuracy.runs.workers import cores, workers
    from warp_softbody.teaching.search import Search

    count = args.workers or cores()
    found: list[Candidate] = []
    with (
        CountBar(f"{task.character.name} learns to {task.do}", args.draws, quiet=args.quiet) as bar,
        workers(count) as executor,
    ):
        search = Search(task=task, executor=executor, count=count, journal=journal)
        for one in search.run(args.draws, args.seed):
            found.append(one)
            bar.counted(len(found), f"best {max(own.tried.way for own in found):.2f} lengths")
        old = None if held is None else search.of(held)
    best = min(found, key=lambda one: (one.tried.cost, one.number))
    return Outcome(usual=found[0], found=best, held=old, tried=len(found))


def _facts(
    args: argparse.Namespace, outcome: Outcome, held: Mapping[str, float] | None
) -> dict[str, Any]:
    """What is told; ``way``, ``lasted`` and ``gains`` are of what the file has now."""
    usual, old = outcome.usual.tried, outcome.held
    own, gains = usual, {}
    if outcome.better:
        own, gains = outcome.found.tried, dict(outcome.found.lesson)
    elif old is not None and held is not None:
        own, gains = old, dict(held)
    return {
        "character": str(args.character),
        "do": args.do,
        "tried": outcome.tried,
        "seconds": args.seconds,
        "usual_way": usual.way,
        "usual_lasted": usual.lasted,
        "held_way": None if old is None else old.way,
        "held_lasted": None if old is None else old.lasted,
        "way": own.way,
        "lasted": own.lasted,
        "kept": outcome.better,
        "gains": gains,
    }


def _as_text(args: argparse.Namespace, facts: dict[str, Any]) -> str:
    def told(way: float, lasted: float) -> str:
        fell = "" if lasted >= 1.0 else f" and fell after {lasted * args.seconds:.1f} s"
        return f"went {way:.2f} of its length in {args.seconds:g} s{fell}"

    lines = [
        f"{args.character}: {facts['tried']} gains tried for --do {args.do}, each on two grounds",
        f"  usual       {told(facts['usual_way'], facts['usual_lasted'])}",
    ]
    if facts["held_way"] is not None:
        lines.append(f"  held        {told(facts['held_way'], facts['held_lasted'])}")
        if not facts["kept"]:
            left = f"  found       nothing better; {args.character} holds what it held"
            return "\n".join([*lines, left])
    if not facts["kept"]:
        return "\n".join([*lines, "  found       nothing better; more --draws may find it"])
    gains = ", ".join(f"{name} {value:.3g}" for name, value in facts["gains"].items())
    return "\n".join(
        [
            *lines,
            f"  found       {told(facts['way'], facts['lasted'])}",
            f"  gains       {gains}",
            f"  kept in     {args.character}, for `warp-softbody run {args.character} "
            f"--do {args.do}`",
        ]
    )
