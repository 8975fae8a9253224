"""The process in which a mesher runs: `python worker.py FOLDER`.

A mesher is native code that may crash, print or never end, and none of this may reach the caller.
The folder holds `job.npz`; `result.npz` is written beside it. The mesher itself runs in a fork:
this process waits for it, and when its standard input ends, because the caller gave up or is gone
in any way, it ends the fork and removes the folder. This file imports nothing of the package, so
that a child starts in the time that NumPy and the mesher take.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import select
import shutil
import signal
import sys
import types
from pathlib import Path
from typing import Any

Arrays = tuple[Any, Any]


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


def work(folder: Path) -> None:
    """Do the job of a folder and leave its result, or the error's text, beside it."""
    import numpy as np

    with np.load(folder / "job.npz") as job:
        points, faces = job["points"], job["faces"].astype(np.int32)
        settings = json.loads(str(job["settings"]))
    try:
        nodes, tets = MESHERS[settings["mesher"]](points, faces, settings["options"])
    except Exception as error:
        np.savez(folder / "result.npz", error=f"{type(error).__name__}: {error}")
    else:
        np.savez(folder / "result.npz", points=nodes, tets=tets)


def main(folder: Path) -> None:
    """Run the mesher in a fork and exit as it did, or end it once the caller is gone."""
    caller = os.getppid()
    ending, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            work(folder)
            status = 0
        finally:
            os._exit(status)
    # The fork holds the other end of this pipe until it ends, however it does.
    os.close(writing)
    ready: list[int] = []
    while not ready and os.getppid() == caller:
        ready, _, _ = select.select([0, ending], [], [], 1.0)
    if ending not in ready:
        os.kill(child, signal.SIGKILL)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if ending not in ready:
        shutil.rmtree(folder, ignore_errors=True)
    if status < 0:
        signal.raise_signal(-status)
    os._exit(status)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
