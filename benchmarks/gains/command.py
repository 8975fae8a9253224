"""Search the gains of a scene by CMA-ES around the shipped ones.

    python -m benchmarks.gains balance-i --draws 100 --seed 1 --out balance-i.csv
    python -m benchmarks.gains jump-i --family "as shipped" "dt / 2" "coarser mesh + push=0.2"

Each candidate is run in every member of a family: variations of `benchmarks.fidelity` and
`benchmarks.robustness`, joined by " + ", with settings of the scene (NAME=VALUE) and side=DEGREES,
which turns the pushes. A run costs the sum of what is missing to the criteria of
`benchmarks.motions.criteria` with a margin, each as a share of its bound and with the stricter
bounds of the case; a run in which the body falls stops and costs more, the sooner the more. A
candidate costs what its worst member costs, and a tenth of the mean. It is given up when it is
worse than the best of the generations before; members that were worst come first. Finished runs
are in a journal, so that a search that was stopped goes on; runs of another state of the program
are made anew.
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.beam.arguments import count
from benchmarks.gains.cases import CASES
from benchmarks.gains.family import family
from benchmarks.gains.journal import TrialJournal
from benchmarks.gains.search import Draw, FamilySearch
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.other_meshes import make_meshes
from warp_softbody.accuracy.runs.workers import workers
from warp_softbody.atomic_files import replacing
from warp_softbody.errors import SoftBodyError

JOURNAL = Path("out/gains.jsonl")
STOPPED = 130
"""Exit status after Ctrl-C, as of a command that the signal ended."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Search, keep all draws, print the best."""
    parser = _parser()
    args = parser.parse_args(arguments)
    draws: list[Draw] = []
    try:
        _search(args, draws)
    except KeyboardInterrupt:
        print(f"\nstopped; the finished runs are in {args.journal}", file=sys.stderr)
        return STOPPED
    except SoftBodyError as error:
        parser.error(str(error))
    for draw in sorted(draws, key=lambda draw: draw.cost)[: args.best]:
        print(f"\n{line(args.scene, draw)}")
        print("  ".join(f"{name}={value:.4g}" for name, value in draw.gains.items()))
        for name, cost in draw.costs.items():
            print(f"    {cost:8.4f}  {name}: {_numbers(args.scene, draw, name)}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.gains",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scene", choices=sorted(CASES))
    parser.add_argument("--family", nargs="+", metavar="MEMBER", help="default the scene's own")
    parser.add_argument("--draws", type=count, default=50, help="candidates (50)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    parser.add_argument("--margin", type=float, default=0.1, help="asked of every bound (0.1)")
    parser.add_argument("--workers", type=count, default=1, help="processes (1)")
    parser.add_argument("--best", type=count, default=3, help="draws that are shown (3)")
    parser.add_argument("--journal", type=Path, default=JOURNAL, help=f"finished runs ({JOURNAL})")
    parser.add_argument("--out", type=Path, help="CSV file of all draws")
    return parser


def _search(args: argparse.Namespace, draws: list[Draw]) -> None:
    """Fill the list of draws, and the table of them, as they come."""
    case = CASES[args.scene]
    members = family(args.scene, args.family or case.family)
    args.journal.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, workers(args.workers) as executor:
        for edges in sorted({member.edges for member in members} - {1.0}):
            make_meshes(Path(folder), edges)
        search = FamilySearch(
            case=case,
            members=members,
            journal=TrialJournal(args.journal),
            executor=executor,
            count=args.workers,
            meshes=Path(folder),
            seconds=args.seconds,
            margin=args.margin,
        )
        for draw in search.run(args.draws, args.seed):
            draws.append(draw)
            print(line(args.scene, draw), flush=True)
            if args.out:
                write(args.out, draws, [member.name for member in members])


def line(scene: str, draw: Draw) -> str:
    """A draw's number, cost and worst member with its own number."""
    worst = draw.worst
    ended = "" if draw.whole else f", given up after {len(draw.costs)}"
    return f"{draw.number:4d}  {draw.cost:8.4f}  {worst}: {_numbers(scene, draw, worst)}{ended}"


def _numbers(scene: str, draw: Draw, member: str) -> str:
    """The scene's own number, volume and reversals; or when the run came to a bad end."""
    trial = draw.trials[member]
    if not trial.values:
        return f"falls after {trial.lasted:.2f} s"
    own, values = CRITERIA[scene][0], trial.values
    return (
        f"{own.name} {own.text(values[own.name])}, volume {values['volume']:.1%}, "
        f"reversals {values['reversals']:.1%}"
    )


def write(path: Path, draws: Sequence[Draw], members: Sequence[str]) -> None:
    """A line a draw: number, cost, worst member, gains, and the cost of each member run."""
    rows = [
        {"number": draw.number, "cost": draw.cost, "worst": draw.worst, **draw.gains}
        | {name: draw.costs.get(name, "") for name in members}
        for draw in draws
    ]
    with replacing(path) as new, new.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
