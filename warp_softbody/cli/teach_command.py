"""`warp-softbody teach NAME.char --do walk` searches gains with which a body goes further."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warp_softbody.cli.arguments import number, whole
from warp_softbody.cli.interruption import Interrupted, held_back
from warp_softbody.cli.output import say
from warp_softbody.cli.progress import CountBar
from warp_softbody.errors import OutputError
from warp_softbody.inputs.extras import require_package

if TYPE_CHECKING:
    from warp_softbody.teaching.search import Candidate
    from warp_softbody.teaching.task import Task

BETTER, TRAVELS = 0.02, 0.1
"""Body lengths by which a try has to cost less than that of the usual gains, and has to come, to be
kept: a body that learns to stand has not learnt to walk."""


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
        SoftBodyError: the file is no character's, the body cannot do it, or cmaes is missing.
        Interrupted: by a signal; what was tried is kept.
    """
    require_package("cmaes", "searches", "teach")
    with held_back():
        from warp_softbody.atomic_files import require_writable
        from warp_softbody.body.character import Character
        from warp_softbody.body.lessons import write_lesson
        from warp_softbody.teaching.task import Task

    task = Task(character=Character.load(args.character), do=args.do, seconds=args.seconds)
    folder = args.character.parent
    try:
        require_writable(folder)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written in: {error.strerror or error}") from error
    journal = args.journal or folder / f"{args.character.stem}.{args.do}.jsonl"
    try:
        candidates = _search(args, task, journal)
    except Interrupted as interrupted:
        interrupted.left = f"; what was tried is in {journal}, and the same command goes on there"
        raise
    usual, found = candidates[0], min(candidates, key=lambda one: (one.tried.cost, one.number))
    kept = found.tried.cost < usual.tried.cost - BETTER and found.tried.way >= TRAVELS
    if kept:
        write_lesson(args.character, args.do, found.lesson)
    facts = _facts(args, usual, found, len(candidates), kept=kept)
    if args.json:
        say(json.dumps(facts))
    elif not args.quiet:
        say(_as_text(args, facts))
    return 0


def _search(args: argparse.Namespace, task: Task, journal: Path) -> list[Candidate]:
    """All candidates, the usual gains first."""
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
    return found


def _facts(
    args: argparse.Namespace, usual: Candidate, found: Candidate, tried: int, *, kept: bool
) -> dict[str, Any]:
    best = found if kept else usual
    return {
        "character": str(args.character),
        "do": args.do,
        "tried": tried,
        "seconds": args.seconds,
        "usual_way": usual.tried.way,
        "usual_lasted": usual.tried.lasted,
        "way": best.tried.way,
        "lasted": best.tried.lasted,
        "kept": kept,
        "gains": dict(best.lesson),
    }


def _as_text(args: argparse.Namespace, facts: dict[str, Any]) -> str:
    def told(way: float, lasted: float) -> str:
        fell = "" if lasted >= 1.0 else f" and fell after {lasted * args.seconds:.1f} s"
        return f"went {way:.2f} of its length in {args.seconds:g} s{fell}"

    lines = [
        f"{args.character}: {facts['tried']} gains tried for --do {args.do}, each on two grounds",
        f"  usual       {told(facts['usual_way'], facts['usual_lasted'])}",
    ]
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
