"""Times of a step on one core, in one table, beside other programs and other checkouts.

    python -m benchmarks.speed                                  # every row
    python -m benchmarks.speed --rows walk-x jump-t --against ../before
    python -m benchmarks.speed --peers --write docs/performance.md

Each program does its work in a process of its own; they take a few steps each in turn, so that a
change of the machine's speed hits all alike. Times are CPU times, so that other work on the machine
counts little. The column `time` is that of this program, in single precision where it may choose;
all others are ratios: of double precision and of other checkouts over `time`, of peers, which
compute in double precision, over this program's double precision. Above 1 the other takes longer.

Peers are MuJoCo (its implicit flex, solved to our tolerance), a step of our equations by NumPy and
MKL Pardiso, and Drake's deformable bodies; those that are not installed are left out, with a line.
They come with the extra `bench`. They step the beam alone.

Starts are of `run crawl-i`, to the end of its second frame, as wall time: other work on the machine
counts. `start-cold` begins with an empty cache of compiled kernels.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import platform
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.beam.arguments import progress
from benchmarks.marked_page import put
from benchmarks.speed.processes import HERE, time_in_turn
from benchmarks.speed.starts import CommandTime, cold, warm
from benchmarks.speed.table import BEGIN, END, Timing, markdown
from benchmarks.speed.works import OURS, OURS_FLOAT64, PEERS, Work, works

STARTS: dict[str, tuple[str, Callable[[Path], CommandTime]]] = {
    "start-warm": ("`run crawl-i` to its second frame, kernels compiled", warm),
    "start-cold": ("the same with an empty cache", cold),
}
ROWS = (*works(), *STARTS)


def measure(names: Sequence[str], *, peers: bool, against: Sequence[Path]) -> list[Timing]:
    """The rows asked for; stopped by Ctrl-C, those that are done."""
    installed = _installed() if peers else []
    checkouts: dict[str, Path | None] = {str(path): path for path in against}
    done: list[Timing] = []
    try:
        for name in names:
            if name in STARTS:
                done.append(_start(name, against))
            else:
                done.append(_work(works()[name], peers, installed, checkouts))
    except KeyboardInterrupt:
        print("stopped; the rows that are done follow", file=sys.stderr)
    progress("")
    return done


def _work(
    work: Work, peers: bool, installed: Sequence[str], checkouts: dict[str, Path | None]
) -> Timing:
    programs: dict[str, Path | None] = {OURS: None, **checkouts}
    if peers and work.peers:
        programs |= dict.fromkeys((OURS_FLOAT64, *installed))
    times = time_in_turn(work, programs, progress)
    return Timing(name=work.name, about=work.about, unit=work.unit, times=times)


def _start(name: str, against: Sequence[Path]) -> Timing:
    about, take = STARTS[name]
    times = {}
    for program, root in {OURS: HERE, **{str(path): path for path in against}}.items():
        progress(f"{name}: {program}")
        times[program] = take(root).wall
    return Timing(name=name, about=about, unit="s", times=times)


def _installed() -> list[str]:
    """Peers that can be imported, with a line on stderr about each other one."""
    found = []
    for program, module in PEERS.items():
        if importlib.util.find_spec(module) is None:
            print(
                f"{program} is left out: it needs the package of the module {module}; install it "
                "with pip install 'warp-softbody[bench]'",
                file=sys.stderr,
            )
        else:
            found.append(program)
    return found


def _checkout(text: str) -> Path:
    path = Path(text)
    if not (path / "warp_softbody" / "__init__.py").is_file():
        raise argparse.ArgumentTypeError(f"{text!r} is no checkout of warp_softbody")
    return path


def main(arguments: Sequence[str] | None = None) -> int:
    """Time the rows asked for and print them; 1 where one is missing."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--rows",
        nargs="+",
        choices=ROWS,
        default=ROWS,
        metavar="ROW",
        help=f"out of {', '.join(ROWS)}",
    )
    parser.add_argument("--peers", action="store_true", help="also time MuJoCo, Pardiso and Drake")
    parser.add_argument(
        "--against",
        nargs="+",
        type=_checkout,
        default=[],
        metavar="FOLDER",
        help="other checkouts of this program to time beside it",
    )
    parser.add_argument("--write", type=Path, metavar="PAGE", help="put the table into a page")
    parser.add_argument("--json", action="store_true", help="print a list of objects, one a row")
    args = parser.parse_args(arguments)
    timings = measure(args.rows, peers=args.peers, against=args.against)
    if args.json:
        print(json.dumps([asdict(timing) for timing in timings]))
    else:
        print(markdown(timings))
    complete = len(timings) == len(args.rows) and all(OURS in one.times for one in timings)
    if args.write is not None:
        if not complete:
            print(f"{args.write} is left as it was: rows are missing", file=sys.stderr)
            return 1
        put(args.write, BEGIN, END, f"{markdown(timings)}\n\n{_where()}")
    return 0 if complete else 1


def _where() -> str:
    """A sentence of the machine and the day."""
    return f"Written on {time.strftime('%Y-%m-%d')}, on {_processor()}."


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2] for line in text.splitlines() if line.startswith("model name")]
    return names[0].strip() if names else platform.machine()
