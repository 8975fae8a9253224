"""A process that serves beside a run is forked from it, and hears none of its signals."""

from __future__ import annotations

import gc
import os
import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from warp_softbody.stage_exports.usd.byte_ring import ByteRing
from warp_softbody.stage_exports.usd.messages import Messages
from warp_softbody.world.scene import Scene

HEARD = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that are for the run; the writer ends with it."""

STOP = signal.SIGUSR1
"""What a run sends that does not wait for the end of the writing."""


def forked(
    ours: Messages,
    theirs: Messages,
    ring: ByteRing,
    arguments: tuple[Path, Scene, Mapping[str, Any]],
) -> int:
    """Number of a process that serves at ``theirs``; signals for the run do not reach it."""
    # the collector of garbage would write on all that there is, and each page on which one of the
    # two writes is copied
    gc.freeze()
    signal.pthread_sigmask(signal.SIG_BLOCK, HEARD)
    try:
        process = os.fork()
        if process == 0:
            ours.close()
            _serve(theirs, ring, arguments)
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, HEARD)
    theirs.close()
    return process


def _serve(
    pipe: Messages, ring: ByteRing, arguments: tuple[Path, Scene, Mapping[str, Any]]
) -> NoReturn:
    """Write until there is nobody to write for; this process never returns to its copy of the run.

    What the run prints is not its business, so that it leaves the streams alone; but it holds them
    as long as it lives, so that whoever waits for their end finds the stage as it stays.
    """
    code = 1
    try:
        for number in HEARD:
            signal.signal(number, signal.SIG_IGN)
        signal.signal(STOP, signal.default_int_handler)
        ring.settle()
        from warp_softbody.stage_exports.usd.beside_service import serve

        serve(pipe, ring, *arguments)
        code = 0
    finally:
        os._exit(code)
