"""How much memory the arrays of a simulation take."""

from __future__ import annotations

import gc
import types
from typing import Any

import numpy as np
import warp as wp

from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.world.scene import Scene

_SKIPPED = (type, types.ModuleType, types.FunctionType, types.FrameType, wp.Kernel)
"""What leads from an object to the whole program."""

_GIVEN = (Scene, Character, TetMesh)
"""What a run is given and shares with others, which keep their measures there once found."""


def array_bytes(root: Any) -> int:
    """Bytes of all NumPy and Warp arrays that can be reached from an object, each counted once.

    Arrays of the scene that was given are left out.
    """
    seen: set[int] = set()
    buffers: dict[int, int] = {}
    waiting = [root]
    while waiting:
        item = waiting.pop()
        if id(item) in seen or isinstance(item, (*_SKIPPED, *_GIVEN)):
            continue
        seen.add(id(item))
        if isinstance(item, wp.array):
            buffers[item.ptr] = max(buffers.get(item.ptr, 0), int(item.capacity or 0))
            continue
        if isinstance(item, np.ndarray):
            if item.base is None:
                buffers[item.ctypes.data] = item.nbytes
            else:
                waiting.append(item.base)
            continue
        waiting += gc.get_referents(item)
    return sum(buffers.values())
