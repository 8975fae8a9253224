"""Workers that are not left behind, and work that ends although its workers are lost."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.support.processes import start_python
from warp_softbody.accuracy.runs import dask_cluster
from warp_softbody.accuracy.runs.dask_cluster import Watched
from warp_softbody.errors import SoftBodyError

SWEEP = """
import multiprocessing, os, sys, time
from pathlib import Path
from warp_softbody.accuracy.runs.workers import workers

def busy(folder):
    (Path(folder) / str(os.getpid())).touch()
    time.sleep(600)

if __name__ == "__main__":
    with workers(2) as executor:
        futures = [executor.submit(busy, sys.argv[1]) for _ in range(5)]
        futures[0].result()
"""


def living(process: int) -> bool:
    try:
        text = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return text.rsplit(")", 1)[1].split()[0] not in ("Z", "X")


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize("name", ["SIGINT", "SIGKILL"])
def test_workers_end_with_their_parent(tmp_path: Path, name: str) -> None:
    """Also those that are in the middle of a run of ten minutes."""
    script, busy = tmp_path / "sweep.py", tmp_path / "busy"
    script.write_text(SWEEP)
    busy.mkdir()
    process = start_python(script, busy, stderr=subprocess.PIPE, new_session=True)
    deadline = time.monotonic() + 60.0
    while len(list(busy.iterdir())) < 2:
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.02)
    # Ctrl-C reaches all processes of a terminal
    if name == "SIGINT":
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.kill()
    _, err = process.communicate(timeout=60)
    assert name == "SIGKILL" or err.count("Traceback") == err.count("KeyboardInterrupt") == 1, err
    while any(living(int(path.name)) for path in busy.iterdir()):
        assert time.monotonic() < deadline
        time.sleep(0.02)


class Stuck(ThreadPoolExecutor):
    """An executor whose runs never end."""

    def submit(self, fn: object, /, *args: object, **kwargs: object) -> Future[object]:  # type: ignore[override]
        """Accept, and do nothing."""
        return Future()


@pytest.mark.parametrize("kind", ["no workers", "no scheduler"])
def test_a_cluster_without_workers_is_one_sentence(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_cluster, "LOST_SECONDS", 0.05)
    monkeypatch.setattr(dask_cluster, "LOOK_SECONDS", 0.01)

    def count() -> int:
        if kind == "no scheduler":
            raise OSError("connection refused")
        return 0

    with Watched(Stuck(), count, "tcp://here:1") as executor:
        future = executor.submit(abs, -1)
        with pytest.raises(SoftBodyError, match="'tcp://here:1' has lost its scheduler or its"):
            future.result(timeout=30.0)


def test_a_watched_executor_hands_on_what_the_runs_do() -> None:
    with Watched(ThreadPoolExecutor(1), lambda: 1, "tcp://here:1") as executor:
        assert executor.submit(abs, -3).result(timeout=30.0) == 3
        with pytest.raises(ZeroDivisionError):
            executor.submit(divmod, 1, 0).result(timeout=30.0)
