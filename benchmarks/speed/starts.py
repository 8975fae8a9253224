"""How long a command takes to its first steps, with kernels compiled and with an empty cache."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

SCENE = "crawl-i"
REPEATS = 5
UNKEPT = "PYTHONDONTWRITEBYTECODE"


@dataclass(frozen=True, kw_only=True)
class CommandTime:
    """Seconds of a command that ends with its second frame.

    Attributes:
        wall: from its begin to its end.
        cpu: of all its processes.
    """

    wall: float
    cpu: float


def warm(root: Path, repeats: int = REPEATS) -> CommandTime:
    """Median of several, after one that compiles whatever is not yet."""
    _timed(root, {})
    made = [_timed(root, {}) for _ in range(repeats)]
    return CommandTime(wall=median(one.wall for one in made), cpu=median(one.cpu for one in made))


def cold(root: Path) -> CommandTime:
    """With no kernel compiled."""
    with tempfile.TemporaryDirectory(prefix="speed_") as folder:
        return _timed(root, {"WARP_CACHE_PATH": folder})


def _timed(root: Path, more: dict[str, str]) -> CommandTime:
    """One command in a checkout.

    Raises:
        CalledProcessError: it failed.
    """
    # a user's Python keeps what it has compiled of modules
    own = {name: value for name, value in os.environ.items() if name != UNKEPT}
    command = [sys.executable, "-m", "warp_softbody", "run", SCENE, "--seconds", "0.02", "--quiet"]
    before, begun = os.times(), time.perf_counter()
    subprocess.run(command, cwd=root, env=own | more, check=True, stderr=subprocess.DEVNULL)
    wall, after = time.perf_counter() - begun, os.times()
    cpu = after.children_user - before.children_user + after.children_system
    return CommandTime(wall=wall, cpu=cpu - before.children_system)
