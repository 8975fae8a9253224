"""Where runs are made: processes of this machine, or a Dask cluster; the answers are the same.

Each process makes one run at a time and uses one thread, so that its CPU time is the run's.
"""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait

from warp_softbody.errors import InputError, MissingExtraError

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
CONNECT_SECONDS = 10


@contextmanager
def workers(count: int, dask: str | None = None) -> Iterator[Executor]:
    """So many processes, or those of the cluster at an address.

    Raises:
        MissingExtraError: Dask is asked for but not installed.
        InputError: the cluster does not answer, or its workers have more than one thread.
    """
    if dask is not None:
        with _cluster(dask) as executor:
            yield executor
        return
    saved = {name: os.environ.get(name) for name in ONE_THREAD}
    # read by the libraries of a new process when they are loaded
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    context = multiprocessing.get_context("spawn")
    executor = ProcessPoolExecutor(count, mp_context=context, initializer=_begin)
    try:
        yield executor
    finally:
        executor.shutdown(cancel_futures=True)
        for name, value in saved.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin() -> None:
    """Leave Ctrl-C to the parent, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        distributed = importlib.import_module("distributed")
    except ImportError as error:
        raise MissingExtraError(
            "--dask needs the package distributed, which is not installed: "
            "pip install 'warp-softbody[dask]'"
        ) from error
    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS)
    except (OSError, ValueError) as error:
        raise InputError(f"no Dask scheduler answers at {address!r}") from error
    with client:
        threads = [w["nthreads"] for w in client.scheduler_info(n_workers=-1)["workers"].values()]
        if not threads:
            raise InputError(f"the Dask cluster at {address!r} has no workers")
        if max(threads) > 1:
            raise InputError(
                f"a Dask worker at {address!r} has {max(threads)} threads; start workers with "
                "--nthreads 1, so that the CPU time of a process is that of one run"
            )
        with client.get_executor(pure=False) as executor:
            yield executor
