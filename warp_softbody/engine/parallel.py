"""Phases of independent work on more than one thread.

A launch on the CPU runs on the thread that asks for it and lets other threads run meanwhile, so
each thread replays the graph of its own share and waits for the others after every phase.
"""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor, wait
from functools import partial
from typing import Any

import warp as wp

from warp_softbody.device.warp_runtime import captured
from warp_softbody.engine.assembly import Phase


class Workers:
    """Threads that replay shares of captured phases."""

    def __init__(self, threads: int, device: str) -> None:
        """Start ``threads`` minus one of them; the caller's own is the last."""
        self._threads = threads
        self._device = device
        self._pool = ThreadPoolExecutor(threads - 1, thread_name_prefix="warp_softbody")

    def capture(self, phases: list[Phase]) -> list[list[Any]]:
        """Graphs by phase and thread."""
        graphs = []
        for phase in phases:
            cuts = [phase.count * k // self._threads for k in range(self._threads + 1)]
            shares = []
            for first, last in itertools.pairwise(cuts):
                shares.append(captured(self._device, partial(_launch, phase, first, last)))
            graphs.append(shares)
        return graphs

    def replay(self, graphs: list[list[Any]]) -> None:
        """Run the phases one after the other, the shares of each side by side."""
        for mine, *others in graphs:
            running = [self._pool.submit(wp.capture_launch, graph) for graph in others]
            wp.capture_launch(mine)
            wait(running)
            for done in running:
                done.result()


def _launch(phase: Phase, first: int, last: int) -> None:
    if last > first:
        phase.launch(first, last)
