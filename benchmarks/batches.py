"""Many characters in a batch beside single runs: ``python -m benchmarks.batches``.

    python -m benchmarks.batches                            # 16 letters, passive and controlled
    python -m benchmarks.batches --members 1000 --rows passive
    python -m benchmarks.batches --members 16 100 1000 --write docs/performance.md

A single run and the batch take a few steps each in turn, so that a change of the machine's speed
hits both. Times are CPU times of the process a step and character, medians over the turns; the
first step of a turn of the single run is not counted, so that it finds its arrays in the caches as
it does alone. Set-up and memory are those of a further member, its graphs included. Controlled
letters are `balance-i`, pushed within the steps that are timed.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.beam.arguments import count, progress
from benchmarks.marked_page import put, rows
from benchmarks.tables import as_text
from warp_softbody import scenes
from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.batch import Batch
from warp_softbody.run.batch_member import BatchMember
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

ROWS = ("passive", "controlled")
OPTIONS = SimulationOptions(time_step=1.0 / 60.0, precision="float32", sleep=False)
CONTROLLED = "balance-i"
MOST_CONTROLLED = 100
"""Members of a controlled row; more are left out, as they take minutes to build."""
BEGIN = "<!-- many characters: written by python -m benchmarks.batches, from here -->"
END = "<!-- many characters: to here -->"
TURN = 6
"""Steps of either side before the other has its turn."""
CAPTURING = 4
"""Steps that count as set-up; the first two capture graphs."""
LANDING = 36
"""Further steps before the clock starts, in which bodies land."""


@dataclass(frozen=True, kw_only=True)
class BatchTiming:
    """What a batch and a single run took.

    Attributes:
        single, batch: ms of CPU time a step and character.
        setup: ms of CPU time a member.
        memory: MB a member; nan where the system does not tell.
    """

    single: float
    batch: float
    setup: float
    memory: float

    @property
    def ratio(self) -> float:
        """Steps of the batch in the time of one of a single run."""
        return self.single / self.batch


def member(row: str, index: int = 0) -> BatchMember:
    """One of the characters of a row."""
    random = np.random.default_rng(index)
    if row == "passive":
        letter: Character = replace(letter_i(), muscles=())
        scene = Scene(character=letter, ground=Plane(friction=0.8, offset=-0.05))
        return BatchMember(index=index, scene=scene, random=random)
    plan = scenes.make(CONTROLLED)
    return BatchMember(index=index, scene=plan.scene, controller=plan.controller, random=random)


def timed(row: str, members: int, steps: int, threads: int) -> BatchTiming:
    """Time a batch of a row beside a single run."""
    first = member(row)
    single = Simulation(first.scene, first.controller, options=OPTIONS)
    for _ in range(CAPTURING + LANDING):
        single.step()
    held, begun = _resident(), time.process_time()
    batch = Batch(
        first.scene,
        members,
        lambda made: replace(made, controller=member(row).controller),
        options=OPTIONS,
        threads=threads,
    )
    for _ in range(CAPTURING):
        batch.step()
        progress(f"{row}: set-up of {members}")
    setup, memory = time.process_time() - begun, _resident() - held
    for _ in range(LANDING):
        batch.step()
    alone: list[float] = []
    together: list[float] = []
    for turn in range(-(-steps // TURN)):
        alone += [_cpu(single.step) for _ in range(TURN)][1:]
        together += [_cpu(batch.step) / members for _ in range(TURN)]
        progress(f"{row}: {TURN * (turn + 1)} of {steps} steps")
    progress("")
    return BatchTiming(
        single=1e3 * float(np.median(alone)),
        batch=1e3 * float(np.median(together)),
        setup=1e3 * setup / members,
        memory=memory / members,
    )


def _apart(row: str, members: int, steps: int, threads: int) -> BatchTiming:
    """`timed` in a process of its own, so that no earlier row's memory is used again."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as process:
        return process.submit(timed, row, members, steps, threads).result()


def _cpu(step: Callable[[], None]) -> float:
    begun = time.process_time()
    step()
    return time.process_time() - begun


def _resident() -> float:
    """Memory of the process, MB."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    (line,) = (one for one in status.read_text().splitlines() if one.startswith("VmRSS"))
    return float(line.split()[1]) / 1024.0


def main(arguments: Sequence[str] | None = None) -> None:
    """Time the rows asked for."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.batches",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--rows", nargs="+", choices=ROWS, default=list(ROWS))
    parser.add_argument("--members", nargs="+", type=count, default=[16])
    parser.add_argument("--steps", type=count, default=60)
    parser.add_argument("--threads", type=count, default=1)
    parser.add_argument("--write", type=Path, metavar="PAGE", help="put the table into a page")
    args = parser.parse_args(arguments)
    titles = ["row", "members", "single ms", "batch ms", "ratio", "set-up ms", "memory MB"]
    lines = []
    for row in args.rows:
        for members in args.members:
            if row == "controlled" and members > MOST_CONTROLLED:
                continue
            found = _apart(row, members, args.steps, args.threads)
            numbers = (found.single, found.batch, found.ratio, found.setup, found.memory)
            lines.append([row, str(members), *(f"{number:.2f}" for number in numbers)])
    print(as_text(titles, lines, left="row"))
    if args.write is not None:
        put(args.write, BEGIN, END, rows([titles, *lines]))


if __name__ == "__main__":
    main()
