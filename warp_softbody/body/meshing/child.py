"""A mesher runs in a child process; whatever happens to it ends as arrays or as one sentence."""

from __future__ import annotations

import contextlib
import io
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt

from warp_softbody.body.meshing.worker import NO_FOLDER
from warp_softbody.errors import MeshError, OutputError

WORKER = Path(__file__).with_name("worker.py")

GRACE = 3.0
"""s in which a worker that is told to end removes its folder."""

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
    worker: Path = WORKER,
    grace: float = GRACE,
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
        worker: script that the child runs.
        grace: s in which a child that is told to end may remove its folder.

    Returns:
        Points (k, 3) m and tets (m, 4), unchecked.

    Raises:
        MeshError: the mesher refused the surface, crashed or took too long.
        OutputError: the child cannot be started, or finds no temporary folder.
    """
    job = io.BytesIO()
    settings = json.dumps({"mesher": mesher, "options": dict(options)})
    np.savez(job, points=points, faces=faces, settings=settings)
    try:
        code, answer = _run_child(job.getvalue(), timeout, worker, grace)
    except subprocess.TimeoutExpired as error:
        raise MeshError(
            f"{source}: {mesher} did not finish in {timeout:.3g} s; "
            + (remedy or "try a larger size or another mesher")
        ) from error
    except OSError as error:
        raise OutputError(f"{source}: {mesher} cannot be started: {error.strerror}") from error
    if code == NO_FOLDER:
        raise OutputError(
            f"{source}: there is no temporary folder for {mesher}; TMPDIR names another one"
        )
    return _result(answer, mesher, source, code)


def _run_child(job: bytes, timeout: float, worker: Path, grace: float) -> tuple[int, bytes]:
    """Exit status and answer of the worker; whatever happens here, it is gone afterwards.

    It runs in a session of its own, so that a signal to this process's group leaves it to end by
    itself: it sees the end of its standard input and removes its folder.
    """
    paths = os.pathsep.join(os.path.abspath(path) for path in sys.path)
    process = subprocess.Popen(
        [sys.executable, str(worker)],
        cwd="/",
        # The child finds what this process finds, though it runs elsewhere.
        env={**os.environ, "PYTHONPATH": paths},
        bufsize=0,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    assert process.stdin is not None and process.stdout is not None
    try:
        # A worker that is gone already tells why by its status.
        with contextlib.suppress(BrokenPipeError):
            for part in (len(job).to_bytes(8, "little"), job):
                _send(process.stdin.fileno(), part)
        answer = _receive(process.stdout.fileno(), timeout)
        return process.wait(), answer
    finally:
        _end(process, grace)


def _send(stream: int, data: bytes) -> None:
    while data:
        data = data[os.write(stream, data) :]


def _receive(stream: int, timeout: float) -> bytes:
    """All that comes until the other side closes the stream."""
    deadline = time.monotonic() + timeout
    parts: list[bytes] = []
    while True:
        left = deadline - time.monotonic()
        if left <= 0.0 or not select.select([stream], [], [], left)[0]:
            raise subprocess.TimeoutExpired("mesher", timeout)
        part = os.read(stream, 2**20)
        if not part:
            return b"".join(parts)
        parts.append(part)


def _end(process: subprocess.Popen[bytes], grace: float) -> None:
    """Let the worker clean up, then end it and what it started; after Ctrl-C too."""
    assert process.stdin is not None and process.stdout is not None
    process.stdin.close()
    try:
        process.wait(timeout=grace)
    except subprocess.TimeoutExpired:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    process.stdout.close()


def _result(answer: bytes, mesher: str, source: str, code: int) -> Arrays:
    try:
        with np.load(io.BytesIO(answer)) as result:
            if code == 0 and "error" not in result:
                return result["points"], result["tets"]
            reason = " ".join(str(result["error"]).split())
    # No answer, half of one, or arrays from a child that crashed after writing them.
    except (OSError, ValueError, EOFError, KeyError, BadZipFile):
        reason = _ending(code)
    raise MeshError(f"{source}: {mesher} could not mesh the surface: {reason}")


def _ending(code: int) -> str:
    """How a child ended, from its exit status."""
    if code < 0:
        return f"it was ended by {signal.Signals(-code).name}"
    return f"it ended with status {code}" if code else "it left no result"
