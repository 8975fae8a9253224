"""What writing a stage adds to a run: `python -m benchmarks.export_share`.

Each scene is run as ``warp-softbody run SCENE --fps 60``, in turn with a stage and without, in
processes of their own with one thread, and the least wall time of each kind counts. The share of
the run loop is from the summary: seconds in which the run waited for its stage over all of its
seconds. CPU times count the process that writes beside the run too.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.tables import as_text
from warp_softbody import scenes

PR_SET_CHILD_SUBREAPER = 36


@dataclass(frozen=True)
class TimedRun:
    """What a run took.

    Attributes:
        wall: s, of the whole process.
        cpu: s, of it and of what it started.
        summary: of the run loop.
    """

    wall: float
    cpu: float
    summary: dict[str, Any]

    @property
    def waited(self) -> float:
        """Share of the run loop's wall time."""
        return float(self.summary["export_seconds"] / self.summary["wall_seconds"])


def run(scene: str, fps: float, stage: Path | None) -> TimedRun:
    """One run in a process of its own."""
    output = [] if stage is None else ["--out", str(stage)]
    command = [sys.executable, "-m", "warp_softbody", "run", scene, "--fps", str(fps), "--json"]
    with tempfile.TemporaryFile() as answer:
        begun = time.perf_counter()
        process = subprocess.Popen([*command, *output], stdout=answer, stderr=subprocess.DEVNULL)
        cpu, ended = 0.0, 0
        while ended != process.pid:
            # its writer may end before it does or after
            ended, status, used = os.wait4(-1, 0)
            cpu += used.ru_utime + used.ru_stime
        wall = time.perf_counter() - begun
        process.returncode = os.waitstatus_to_exitcode(status)
        with suppress(ChildProcessError):
            used = os.wait4(-1, 0)[2]
            cpu += used.ru_utime + used.ru_stime
        answer.seek(0)
        return TimedRun(wall, cpu, json.load(answer))


def row(scene: str, fps: float, repeats: int, folder: Path) -> dict[str, str]:
    """A line of the table."""
    run(scene, fps, folder / "first.usdc")
    pairs = [(run(scene, fps, None), run(scene, fps, folder / "a.usdc")) for _ in range(repeats)]
    without, within = zip(*pairs, strict=True)
    bare, wall = (min(one.wall for one in runs) for runs in (without, within))
    quickest = min(within, key=lambda one: one.summary["wall_seconds"])
    loop = quickest.summary["wall_seconds"] - quickest.summary["export_seconds"]
    return {
        "scene": scene,
        "frames": str(quickest.summary["frames"]),
        "ms a frame without": f"{1e3 * loop / quickest.summary['frames']:.2f}",
        "waiting, % of the loop": f"{100 * min(one.waited for one in within):.1f}",
        "process, s": f"{bare:.2f}",
        "with a stage": f"{wall:.2f}",
        "% more": f"{100 * (wall / bare - 1):.1f}",
        "CPU, s": f"{min(one.cpu for one in without):.2f}",
        "CPU with a stage": f"{min(one.cpu for one in within):.2f}",
    }


def main() -> None:
    """Print one row a scene."""
    # processes whose parents have ended become this one's, so that their times are told
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    parser = argparse.ArgumentParser(prog="python -m benchmarks.export_share", description=__doc__)
    parser.add_argument("scenes", nargs="*", default=list(scenes.names()), metavar="SCENE")
    parser.add_argument("--fps", type=float, default=60.0)
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [row(name, given.fps, given.repeats, Path(folder)) for name in given.scenes]
    print(as_text(list(rows[0]), [row.values() for row in rows], left="scene"))


if __name__ == "__main__":
    main()
