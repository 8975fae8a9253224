"""Where runs are made: processes of this machine, or a Dask cluster; the answers are the same.

Each process makes one run at a time and uses one thread, so that its CPU time is the run's.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS")
_PR_SET_PDEATHSIG = 1


@contextmanager
def workers(count: int, dask: str | None = None) -> Iterator[Executor]:
    """So many processes, or those of the cluster at an address.

    When the body ends with an exception or Ctrl-C the processes are ended with their runs in hand;
    otherwise these are waited for.

    Raises:
        MissingExtraError: Dask is asked for but not installed.
        InputError: the cluster does not answer, or its workers have more than one thread.
    """
    if dask is not None:
        from warp_softbody.accuracy.runs.dask_cluster import cluster

        with cluster(dask) as executor:
            yield executor
        return
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    with _one_thread_each():
        # multiprocessing's own helper is started here
        with _signals_wait():
            processes = _Processes(
                count, mp_context=context, initializer=_begin, initargs=(os.getpid(),)
            )
        try:
            yield processes
        except BaseException:
            for child in set(multiprocessing.active_children()) - others:
                child.kill()
            raise
        finally:
            processes.shutdown(cancel_futures=True)


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class _Processes(ProcessPoolExecutor):
    """Processes that never see what their terminal sends, not even while they start."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Start processes where none are yet."""
        with _signals_wait():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def _signals_wait() -> Iterator[None]:
    """Ctrl-C and the end of the terminal wait; processes that are started inherit that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """What the libraries of a new process read when they are loaded."""
    saved = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in saved.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin(parent: int) -> None:
    """Leave Ctrl-C to the parent, and end with it, however it ends."""
    for name in ("SIGINT", "SIGHUP"):
        signal.signal(getattr(signal, name), signal.SIG_IGN)
    if sys.platform == "linux":
        # the system ends this process even where it is busy in compiled code
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
    process = multiprocessing.parent_process()
    if process is not None:
        threading.Thread(target=_end_with, args=(process.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
