"""The process in which a mesher runs: `python worker.py FOLDER`.

A mesher is native code that may crash, print or never end, and none of this may reach the caller.
The folder holds `job.npz`; `result.npz` is written beside it. This file imports nothing of the
package, so that a child starts in the time that NumPy and the mesher take.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import resource
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Arrays = tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]


def mesh_by_tetgen(points: Any, faces: Any, options: dict[str, Any]) -> Arrays:
    """Run TetGen's `tetrahedralize` with its own option names."""
    import tetgen

    mesher = tetgen.TetGen(points, faces.astype(np.int32))
    nodes, tets, *_ = mesher.tetrahedralize(**options)
    return nodes, tets


def mesh_by_ftetwild(points: Any, faces: Any, options: dict[str, Any]) -> Arrays:
    """Run fTetWild's `tetrahedralize` with its own option names."""
    # pytetwild 0.4 imports PyVista on import, which it needs only for its PyVista interface.
    if importlib.util.find_spec("pyvista") is None:
        sys.modules["pyvista"] = types.ModuleType("pyvista")
    pytetwild: Any = importlib.import_module("pytetwild")
    nodes, tets = pytetwild.tetrahedralize(points, faces.astype(np.int32), **options)
    return nodes, tets


MESHERS = {"tetgen": mesh_by_tetgen, "ftetwild": mesh_by_ftetwild}


def main(folder: Path) -> None:
    """Do the job of a folder and leave its result, or the error's text, beside it."""
    with np.load(folder / "job.npz") as job:
        points, faces = job["points"], job["faces"]
        settings = json.loads(str(job["settings"]))
    # A child whose parent was killed ends by itself.
    limit = int(settings["cpu_seconds"])
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    try:
        nodes, tets = MESHERS[settings["mesher"]](points, faces, settings["options"])
    except Exception as error:
        np.savez(folder / "result.npz", error=f"{type(error).__name__}: {error}")
    else:
        np.savez(folder / "result.npz", points=nodes, tets=tets)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
