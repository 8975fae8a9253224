"""Runs on a Dask cluster, which may lose its workers or its scheduler at any time."""

from __future__ import annotations

import importlib
import logging
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future, InvalidStateError
from contextlib import contextmanager, suppress
from typing import Any, ParamSpec, TypeVar

from warp_softbody.errors import InputError, MissingExtraError, SoftBodyError

P = ParamSpec("P")
T = TypeVar("T")

CONNECT_SECONDS = 10
LOST_SECONDS = 10.0
"""s without a worker after which none is waited for; a worker that is started again takes less."""
LOOK_SECONDS = 1.0


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """The workers of a cluster.

    Raises:
        MissingExtraError: Dask is not installed.
        InputError: the cluster does not answer, or its workers have more than one thread.
    """
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
    with _quiet(), client:
        threads = [worker["nthreads"] for worker in _workers(client).values()]
        if not threads:
            raise InputError(f"the Dask cluster at {address!r} has no workers")
        if max(threads) > 1:
            raise InputError(
                f"a Dask worker at {address!r} has {max(threads)} threads; start workers with "
                "--nthreads 1, so that the CPU time of a process is that of one run"
            )
        made = client.get_executor(pure=False)
        with Watched(made, lambda: len(_workers(client)), address) as executor:
            yield executor


@contextmanager
def _quiet() -> Iterator[None]:
    """No tracebacks of Dask's own about a connection that is lost."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


class Watched(Executor):
    """An executor whose runs fail once there has been nobody to make them for some time."""

    def __init__(self, inner: Executor, count: Callable[[], int], address: str) -> None:
        """Watch from the first run on.

        Args:
            inner: makes the runs.
            count: how many workers there are; it may fail where nobody can tell.
            address: of the cluster, for the sentence.
        """
        self._address = address
        self._inner = inner
        self._count = count
        self._open: set[Future[Any]] = set()
        self._ended = threading.Event()
        self._watch: threading.Thread | None = None

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """A run that ends even where its worker does not."""
        future: Future[T] = Future()
        self._open.add(future)
        self._inner.submit(fn, *args, **kwargs).add_done_callback(
            lambda made: self._pass_on(made, future)
        )
        if self._watch is None:
            self._watch = threading.Thread(target=self._look, daemon=True)
            self._watch.start()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop watching; runs that are left are given up."""
        self._ended.set()
        with suppress(Exception):
            self._inner.shutdown(wait=False)

    def _pass_on(self, made: Future[T], future: Future[T]) -> None:
        self._open.discard(future)
        with suppress(InvalidStateError):
            try:
                future.set_result(made.result())
            except CancelledError:
                self._fail(future)
            except Exception as error:
                future.set_exception(error)

    def _look(self) -> None:
        seen = time.monotonic()
        while not self._ended.wait(LOOK_SECONDS):
            if self._alive():
                seen = time.monotonic()
            elif time.monotonic() - seen > LOST_SECONDS:
                for future in list(self._open):
                    self._fail(future)

    def _alive(self) -> bool:
        # what Dask raises without its scheduler depends on where it notices
        with suppress(Exception):
            return self._count() > 0
        return False

    def _fail(self, future: Future[Any]) -> None:
        self._open.discard(future)
        with suppress(InvalidStateError):
            future.set_exception(
                SoftBodyError(
                    f"the Dask cluster at {self._address!r} has lost its scheduler or its last "
                    "worker; finished runs are kept in the journal"
                )
            )


def _workers(client: Any) -> dict[str, Any]:
    found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return found
