"""The process in which a mesher runs: `python worker.py`, the job on its standard input.

A mesher is native code that may crash, print or never end, and none of this may reach the caller.
It runs in a fork, in a folder of its own, because fTetWild leaves a file where it works. This
process waits for the fork, and when its standard input ends, because the caller gave up or is gone
in any way, it ends the fork. The folder goes with it. This file imports nothing of the package, so
that a child starts in the time that NumPy and the mesher take.
"""

from __future__ import annotations

import importlib
import importlib.util
import io
import json
import os
import select
import shutil
import signal
import sys
import tempfile
import types
from pathlib import Path
from typing import Any

Arrays = tuple[Any, Any]

NO_FOLDER = 73
"""Exit status where no temporary folder can be made (EX_CANTCREAT)."""


def mesh_by_tetgen(points: Any, faces: Any, options: dict[str, Any]) -> Arrays:
    """Run TetGen's `tetrahedralize` with its own option names."""
    import tetgen

    mesher = tetgen.TetGen(points, faces)
    nodes, tets, *_ = mesher.tetrahedralize(**options)
    return nodes, tets


def mesh_by_ftetwild(points: Any, faces: Any, options: dict[str, Any]) -> Arrays:
    """Run fTetWild's `tetrahedralize` with its own option names."""
    # pytetwild 0.4 imports PyVista on import, which it needs only for its PyVista interface.
    if importlib.util.find_spec("pyvista") is None:
        sys.modules["pyvista"] = types.ModuleType("pyvista")
    pytetwild: Any = importlib.import_module("pytetwild")
    nodes, tets = pytetwild.tetrahedralize(points, faces, **options)
    return nodes, tets


MESHERS = {"tetgen": mesh_by_tetgen, "ftetwild": mesh_by_ftetwild}


def work(job: bytes, result: Path) -> None:
    """Do a job and leave its result, or the error's text, in a file."""
    import numpy as np

    with np.load(io.BytesIO(job)) as arrays:
        points, faces = arrays["points"], arrays["faces"].astype(np.int32)
        settings = json.loads(str(arrays["settings"]))
    try:
        nodes, tets = MESHERS[settings["mesher"]](points, faces, settings["options"])
    except Exception as error:
        np.savez(result, error=f"{type(error).__name__}: {error}")
    else:
        np.savez(result, points=nodes, tets=tets)


def run_in_fork(job: bytes, folder: Path) -> int:
    """Do a job in a fork; how the fork ended, or 1 where the caller is gone before it."""
    caller = os.getppid()
    ending, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.chdir(folder)
            # What a mesher prints is no part of the answer.
            silence = os.open(os.devnull, os.O_RDWR)
            for stream in range(3):
                os.dup2(silence, stream)
            work(job, folder / "result.npz")
            status = 0
        finally:
            os._exit(status)
    # The fork holds the other end of this pipe until it ends, however it does.
    os.close(writing)
    ready: list[int] = []
    try:
        while not ready and os.getppid() == caller:
            ready, _, _ = select.select([0, ending], [], [], 1.0)
    finally:
        if ending not in ready:
            os.kill(child, signal.SIGKILL)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return status if ending in ready else 1


def main() -> int:
    """Run the mesher, answer with the bytes of its result, and return how it ended."""
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(number, lambda *_: sys.exit(1))
    job = sys.stdin.buffer.read(int.from_bytes(sys.stdin.buffer.read(8), "little"))
    try:
        folder = Path(tempfile.mkdtemp(prefix="warp_softbody_mesh_"))
    except OSError:
        return NO_FOLDER
    try:
        status = run_in_fork(job, folder)
        if status == 0:
            with os.fdopen(1, "wb", closefd=False) as answer:
                answer.write((folder / "result.npz").read_bytes())
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return status


if __name__ == "__main__":
    ended = main()
    if ended < 0:
        if -ended != signal.SIGKILL:
            signal.signal(-ended, signal.SIG_DFL)
        signal.raise_signal(-ended)
    sys.exit(ended)
