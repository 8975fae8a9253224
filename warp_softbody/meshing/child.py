"""Run a mesher in a child process and turn whatever happens to it into arrays or one sentence."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from warp_softbody.errors import MeshError, OutputError

WORKER = Path(__file__).with_name("worker.py")

Arrays = tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]


def run_mesher(
    mesher: str,
    points: npt.NDArray[np.float64],
    faces: npt.NDArray[np.int32],
    options: Mapping[str, object],
    *,
    source: str,
    timeout: float,
    remedy: str = "",
) -> Arrays:
    """Fill a closed surface with tets, in a child that Ctrl-C and the timeout end.

    Args:
        mesher: "tetgen" or "ftetwild".
        points: (n, 3) m.
        faces: (f, 3) outward triangles.
        options: keyword arguments of the mesher's own `tetrahedralize`.
        source: what the sentences call the surface.
        timeout: s.
        remedy: what to do where the time is over; empty for a larger size.

    Returns:
        Points (k, 3) m and tets (m, 4), unchecked.

    Raises:
        MeshError: the mesher refused the surface, crashed or took too long.
        OutputError: there is no temporary folder with room for the surface.
    """
    settings = json.dumps({"mesher": mesher, "options": dict(options)})
    try:
        with tempfile.TemporaryDirectory(prefix="warp_softbody_mesh_") as name:
            folder = Path(name)
            np.savez(folder / "job.npz", points=points, faces=faces, settings=settings)
            code = _run_child(folder, timeout)
            return _result(folder, mesher, source, code)
    except subprocess.TimeoutExpired as error:
        raise MeshError(
            f"{source}: {mesher} did not finish in {timeout:.3g} s; "
            + (remedy or "try a larger size or another mesher")
        ) from error
    except OSError as error:
        raise OutputError(
            f"{source}: {mesher} cannot be started in a temporary folder: "
            f"{error.strerror or error}; TMPDIR names another one"
        ) from error


def _run_child(folder: Path, timeout: float) -> int:
    """Run the worker and return its exit status; whatever happens here, it is gone afterwards.

    It runs in a session of its own, so that a signal to this process's group leaves it to end by
    itself: it sees the end of its standard input and removes the folder.
    """
    command = [sys.executable, str(WORKER), str(folder)]
    # The child finds what this process finds, though it runs in a folder of its own, because
    # fTetWild leaves a file in its working folder.
    paths = os.pathsep.join(os.path.abspath(path) for path in sys.path)
    environment = {**os.environ, "PYTHONPATH": paths}
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        return process.wait(timeout=timeout)
    finally:
        # After Ctrl-C too; `subprocess.run` would leave the child unreaped then.
        if process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        assert process.stdin is not None
        process.stdin.close()


def _result(folder: Path, mesher: str, source: str, code: int) -> Arrays:
    try:
        with np.load(folder / "result.npz") as result:
            if code == 0 and "error" not in result:
                return result["points"], result["tets"]
            reason = " ".join(str(result["error"]).split())
    # No result, half of one, or arrays from a child that crashed after writing them.
    except (OSError, ValueError, EOFError, KeyError, BadZipFile):
        reason = _ending(code)
    raise MeshError(f"{source}: {mesher} could not mesh the surface: {reason}")


def _ending(code: int) -> str:
    """How a child ended, from its exit status."""
    if code < 0:
        return f"it was ended by {signal.Signals(-code).name}"
    return f"it ended with status {code}" if code else "it left no result"
