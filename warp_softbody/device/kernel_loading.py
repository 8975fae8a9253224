"""Kernels are loaded side by side, and compiled where they are not yet, before they are launched.

Left to itself Warp compiles a module when the first of its kernels is launched: one by one.
Clang takes nine tenths of that time, and needs nothing of Python's meanwhile.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import warp as wp

MOST_WORKERS = 8
"""Compilers at work at once; each takes some 200 MB."""


def load_side_by_side(device: str, names: Iterable[str]) -> None:
    """Load modules of kernels that are not loaded yet, on all cores that this process may use.

    Modules for graphics cards are left to their launches, since not all of them are for processors
    too, nor all of these for cards.

    Args:
        device: where they are launched.
        names: of the modules.
    """
    modules = [wp.get_module(name) for name in sorted(names)]
    if device != "cpu" or any(_is_on_card(module) for module in modules):
        return
    waiting = [module for module in modules if len(module.kernels) and not module.execs]
    if not waiting:
        return
    # alone, for what all compilers share is made by the first of them
    first, *others = sorted(waiting, key=lambda module: len(module.kernels))
    _load(first)
    with ThreadPoolExecutor(max_workers=_workers()) as pool:
        loads = [pool.submit(_load, module) for module in others]
        try:
            for load in loads:
                load.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _load(module: Any) -> None:
    wp.force_load("cpu", modules=[module], max_workers=0)


def _is_on_card(module: Any) -> bool:
    """Whether a module is loaded somewhere else than on the processor."""
    return any(context is not None for context, _ in module.execs)


def _workers() -> int:
    """Cores that this process may use, within reason."""
    try:
        count = len(os.sched_getaffinity(0))
    except AttributeError:
        count = os.cpu_count() or 1
    return min(count, MOST_WORKERS)
