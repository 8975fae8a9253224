"""What the shipped motions cost and how they look: ``python -m benchmarks.motions``.

Each is run as ``warp-softbody run SCENE --fps 60`` runs it, control and export included, after a
short run that loads the kernels; the rest is measured from its stage. One line a scene, ready for
the README. The factor is simulated seconds per wall second of this machine at this time.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warp_softbody import scenes
from warp_softbody.cli import main as command
from warp_softbody.stage_exports import measure, read_take, reversals

HEADER = (
    "| scene | tets | segments | patches | seconds | real time | ms a step, median (p95) "
    "| assembly | solve | contact | control | export | QPs | volume | reversals |"
)


def controlled() -> list[str]:
    """Shipped scenes with a controller."""
    return [name for name in scenes.names() if scenes.make(name).controller is not None]


def run(scene: str, stage: Path, *more: str) -> dict[str, Any]:
    """The summary of a run."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        command(["run", scene, "--out", str(stage), "--fps", "60", "--json", *more])
    summary: dict[str, Any] = json.loads(output.getvalue())
    return summary


def row(scene: str, folder: Path, more: Sequence[str]) -> str:
    """A line of the table."""
    stage = folder / f"{scene}.usdc"
    run(scene, stage, "--seconds", "0.1", *more)
    summary = run(scene, stage, *more)
    take = read_take(stage)
    measures = measure(take)
    step = summary["step_ms"]
    cells = [
        f"`{scene}`",
        f"{summary['tets']}",
        f"{summary['segments']}",
        f"{summary['patches']}",
        f"{summary['simulated_seconds']:.1f}",
        f"{summary['real_time_factor']:.2f}",
        f"{step['all']['median']:.1f} ({step['all']['p95']:.1f})",
        *(f"{step[part]['median']:.1f}" for part in ("assembly", "solve", "contact")),
        *(f"{step[part]['median']:.1f}" for part in ("control", "export")),
        f"{summary['qps_per_step']['mean']:.1f}",
        f"{100.0 * np.abs(measures.volume_change).max():.1f} %",
        f"{100.0 * reversals(take):.0f} %",
    ]
    return "| " + " | ".join(cells) + " |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.motions", description=__doc__)
    parser.add_argument("scenes", nargs="*", default=controlled(), metavar="SCENE")
    parser.add_argument("--controller", default="qpcc", choices=("qpcc", "static", "none"))
    args = parser.parse_args(arguments)
    print(HEADER)
    print("|" + "---|" * (HEADER.count("|") - 1))
    with tempfile.TemporaryDirectory() as folder:
        for scene in args.scenes:
            print(row(scene, Path(folder), ["--controller", args.controller]), flush=True)
