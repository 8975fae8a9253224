"""`warp-softbody doctor` says what works on this machine, and what to do about what does not."""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from typing import Any

from warp_softbody import __version__
from warp_softbody.cli import installation
from warp_softbody.cli.display import has_display
from warp_softbody.cli.interruption import held_back
from warp_softbody.cli.output import say

FAULTY = 2
STEPS, TIME_STEP = 12, 1.0 / 60.0
OFF = 1e-5
"""Relative error of a fall in single precision that is rounding."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Register the subcommand; its handler is `run`."""
    parser = subparsers.add_parser(
        "doctor",
        help="say what works on this machine",
        description="Look at the installation, compile kernels, and let a body fall to compare it "
        "with the closed form. The exit code is 0 where the program works.",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(handler=run)


def run(args: argparse.Namespace) -> int:
    """Look at everything and tell; return 0 where the program works.

    Raises:
        SoftBodyError: the program is not installed, or kernels can nowhere be built.
    """
    facts = examined()
    say(json.dumps(facts) if args.json else "\n".join(_lines(facts)))
    return 0 if facts["works"] else FAULTY


def examined() -> dict[str, Any]:
    """What is told of this machine."""
    needed = installation.needed()
    fall = _fall()
    return {
        "version": __version__,
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
        "needed": needed,
        "extras": installation.extras(),
        **fall,
        "browser": has_display(),
        "works": None not in needed.values() and fall["fall_error"] <= OFF,
    }


def _fall() -> dict[str, Any]:
    """Where kernels are kept, what a first run takes, and how far a falling box is off.

    Implicit Euler steps of length h fall by g h^2 n (n + 1) / 2 in n steps.
    """
    with held_back():
        import numpy as np

        from warp_softbody import Simulation, scenes
        from warp_softbody.device.warp_runtime import kernel_folder

    begun = time.perf_counter()
    scene = scenes.make("drop-block", {"height": 5.0, "speed": 0.0}).scene
    simulation = Simulation(scene, time_step=TIME_STEP, fps=1.0 / TIME_STEP)
    *_, last = simulation.run(STEPS * TIME_STEP)
    seconds = time.perf_counter() - begun
    start = np.asarray(scene.whole.mesh.points)
    way = float((start - last.positions)[:, 2].mean())
    wanted = float(-scene.gravity[2]) * TIME_STEP**2 * STEPS * (STEPS + 1) / 2.0
    return {
        "kernels": kernel_folder(),
        "first_run_seconds": seconds,
        "fall_error": abs(way / wanted - 1.0),
    }


def _lines(facts: dict[str, Any]) -> list[str]:
    missing = [name for name, version in facts["needed"].items() if version is None]
    there = ", ".join(f"{name} {version}" for name, version in facts["needed"].items() if version)
    lines = [
        f"warp-softbody {facts['version']}, Python {facts['python']}, {facts['machine']}, "
        f"{facts['cores']} cores",
        f"  needed   {there}",
    ]
    if missing:
        lines.append(f"  MISSING  {', '.join(missing)}: pip install {' '.join(missing)}")
    for extra, lacks in facts["extras"].items():
        how = "there"
        if lacks:
            how = f"lacks {', '.join(lacks)}: pip install 'warp-softbody[{extra}]'"
        lines.append(f"  extra    {extra}: {how}")
    right = "as it should" if facts["fall_error"] <= OFF else "WRONG"
    lines += [
        f"  kernels  in {facts['kernels']}; a first run took {facts['first_run_seconds']:.1f} s",
        f"  physics  a falling box is off by {facts['fall_error']:.0e}: {right}",
        "  browser  " + ("can be opened" if facts["browser"] else "no display; open pages by hand"),
    ]
    return lines
