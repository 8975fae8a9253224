"""How near the QPCC solver comes to the optimum, and how fast: ``python -m benchmarks.qpcc``.

Six parts: stored instances from a cold start, in general and in contact form (only where a folder
of them is named), warm-started sequences, the steps of shipped motions, the experiment of Tan, Turk
and Liu (2012) made again, and, where they are asked for, verdicts on random problems beside SCIP.
Times are CPU times of one thread on the machine at hand.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence

import numpy as np

from benchmarks.qpcc import (
    instances as qpcc_instances,
)
from benchmarks.qpcc import (
    paper as qpcc_paper,
)
from benchmarks.qpcc import (
    sequences as qpcc_sequences,
)
from benchmarks.qpcc.instances import Row
from benchmarks.qpcc.peers.comparison import print_comparison
from benchmarks.qpcc.recorded import print_recorded
from benchmarks.qpcc.verdicts import print_verdicts

PARTS = ("instances", "contacts", "sequences", "recorded", "paper", "verdicts")


AIMS = {4: 2, 8: 5, 16: 10, 32: 30}
"""Contacts, and the median ms a solve that are aimed at."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables of the parts asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.qpcc", description=__doc__)
    parser.add_argument(
        "--instances",
        metavar="PATH",
        default=os.environ.get("QPCC_INSTANCES", ""),
        help="folder of .npz instances (default: the variable QPCC_INSTANCES)",
    )
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS[:-1]))
    parser.add_argument("--steps", type=int, default=20, help="of a sequence")
    parser.add_argument("--problems", type=int, default=10, help="of the paper's experiment")
    parser.add_argument("--count", type=int, default=504, help="of random problems")
    parser.add_argument(
        "--peers",
        action="store_true",
        help="compare with SCIP, Ipopt and MPECSS on the instances, those of them at hand",
    )
    args = parser.parse_args(arguments)
    if args.peers:
        if not args.instances:
            parser.error("--peers needs --instances, a folder of .npz instances")
        print_comparison(args.instances)
        return
    if args.instances and "instances" in args.parts:
        print_instances(args.instances)
    if args.instances and "contacts" in args.parts:
        for contacts in (8, 16, 32):
            print_contacts(args.instances, contacts)
    if "sequences" in args.parts:
        print_sequences(args.steps)
    if "recorded" in args.parts:
        print_recorded()
    if "paper" in args.parts:
        print_paper(args.problems)
    if "verdicts" in args.parts:
        print_verdicts(args.count)


def print_instances(folder: str) -> None:
    """General form, cold: everything in the folder that is no contact problem."""
    paths = [p for p in qpcc_instances.paths(folder) if "contact_" not in os.path.basename(p)]
    rows = []
    for path in paths:
        rows.append(qpcc_instances.general_row(path))
        _print_row(rows[-1])
    if not rows:
        return
    worst = max((row.relative for row in rows if np.isfinite(row.value)), default=np.nan)
    print(
        f"general form, cold: {sum(row.reached for row in rows)} of {len(rows)} reached, "
        f"without a point {sum(not np.isfinite(row.value) for row in rows)}, worst gap of the "
        f"others {worst:.2%}, largest residual {max(row.residual for row in rows):.1e}\n",
        flush=True,
    )


def print_contacts(folder: str, contacts: int) -> None:
    """Contact form, cold."""
    rows = []
    for path in qpcc_instances.paths(folder, f"contact_3d_nc{contacts}_*"):
        rows.append(qpcc_instances.contact_row(path))
        _print_row(rows[-1])
    gaps = np.array([row.gap for row in rows if row.gap is not None])
    if gaps.size:
        print(
            f"{contacts} contacts, cold: mean gap {gaps.mean():.2%} of the achievable gain, "
            f"within 1 % {np.mean(gaps <= 0.01):.0%}, "
            f"mean {np.mean([row.seconds for row in rows]):.1f} s\n",
            flush=True,
        )


def print_sequences(steps: int) -> None:
    """Warm starts: without kicks, as in a run, as by default, with more patience."""
    print(
        "gap: mean over the steps of the share missed of the reference's gain over static; "
        "total gap: that of the sums; reference: a long cold search, or any better run"
    )
    titles = [("kicks", 6), ("patience", 9), ("rule", 5), ("QPs", 7), ("aim", 4), ("gap", 9)]
    titles += [("aim", 5)]
    titles += [("total gap", 11), ("ms", 8), ("aim", 4), ("residual", 10)]
    print(f"{'sequence':24}" + "".join(f"{title:>{width}}" for title, width in titles))
    sequences = {(4, "balance-i"): qpcc_sequences.recorded()[:: max(1, 180 // steps)]}
    for contacts in AIMS:
        sequences[contacts, "generated"] = qpcc_sequences.generated(contacts, steps)
    for (contacts, kind), sequence in sequences.items():
        best = qpcc_sequences.references(sequence)
        kicked = qpcc_sequences.KICKED
        settings = [(qpcc_sequences.PLAIN, False), (kicked, True), (kicked, False)]
        settings.append((qpcc_sequences.THOROUGH, False))
        for options, ruled in settings:
            qpcc_sequences.follow(sequence, best, options, ruled=ruled)
        for options, ruled in settings:
            row = qpcc_sequences.follow(sequence, best, options, ruled=ruled)
            print(
                f"{f'{kind}, {contacts} contacts':24}{options.kicks:6d}{options.patience:9d}"
                f"{'yes' if ruled else 'no':>5}{row.qps:7.1f}{40 if options.kicks else 5:4d}"
                f"{row.gap:9.2%}{'1 %':>5}"
                f"{row.total:11.2%}{row.milliseconds:8.2f}{AIMS[contacts]:4d}{row.residual:10.1e}",
                flush=True,
            )
    print()


def print_paper(count: int) -> None:
    """Static contacts, ours and exhaustive search."""
    print(f"{'static':>12}{'ours':>12}{'exhaustive':>12}{'QPs':>6}")
    trials: list[qpcc_paper.MethodComparison] = []
    modes: tuple[int, ...] | None = None
    problems = qpcc_paper.problems(count)
    for problem in problems:
        row, modes = qpcc_paper.trial(problem, modes)
        trials.append(row)
        print(f"{row.static:12.6f}{row.ours:12.6f}{row.exhaustive:12.6f}{row.qps:6d}", flush=True)
    variables = problems[0].control_count + 10 * qpcc_paper.CONTACTS
    print(
        f"{len(trials)} problems of {variables} variables and {10 * qpcc_paper.CONTACTS} pairs: "
        f"gap ratio {qpcc_paper.gap_ratio(trials):.0f}, "
        f"{np.mean([row.qps for row in trials]):.1f} QPs"
    )


def _print_row(row: Row) -> None:
    gap = "" if row.gap is None else f"{row.gap:9.2%}"
    print(
        f"{row.name:32}{row.value:14.6g}{row.best:14.6g}{row.relative:10.1e}{gap} "
        f"{row.residual:9.1e}{row.qps:6d}{row.seconds:8.2f} s  {row.status.lower()}",
        flush=True,
    )
