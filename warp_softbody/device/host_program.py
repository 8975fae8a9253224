"""Native code of one thread on the processor, called with NumPy arrays and nothing else.

The arrays lie one behind the other in two blocks of memory that never move, so that a launch is a
graph, whose replay costs half a microsecond.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.warp_runtime import captured, start

Shape = tuple[int, ...]
Number = TypeVar("Number", bound=np.generic)

DEVICE = "cpu"

LINE = 8
"""Numbers of a cache line, at which every array begins."""


class HostProgram:
    """Arrays that kernels of ``places``, ``counts`` and ``numbers`` work on.

    Attributes:
        numbers: arrays of float64 by name; the caller writes and reads them in place.
        counts: arrays of int32 by name.
    """

    @shares_warp
    def __init__(self, numbers: Mapping[str, Shape], counts: Mapping[str, Shape]) -> None:
        """Lay out zeros for arrays of some shapes; ``places`` tells kernels where each begins.

        First come those of ``numbers``, then those of ``counts``.
        """
        start()
        begins, length = _begins(numbers)
        more, count = _begins(counts)
        self._places: Any = wp.array([*begins, *more], dtype=wp.int32, device=DEVICE)
        doubles: Any = wp.zeros(length, dtype=wp.float64, device=DEVICE)
        whole: Any = wp.zeros(count, dtype=wp.int32, device=DEVICE)
        self._doubles, self._whole = doubles, whole
        self.numbers: dict[str, npt.NDArray[np.float64]] = _views(doubles.numpy(), begins, numbers)
        self.counts: dict[str, npt.NDArray[np.int32]] = _views(whole.numpy(), more, counts)

    def running(self, kernel: Any, *, reads: list[Any], writes: list[Any]) -> Callable[[], None]:
        """What runs a kernel on the arrays' present contents.

        The kernel also takes Warp arrays of the processor that stay in place: those that it reads
        come after ``places``, those that it writes after ``numbers``.
        """
        inputs, outputs = [self._places, *reads], [self._whole, self._doubles, *writes]
        graph = captured(DEVICE, lambda: launch(kernel, 1, inputs, outputs, DEVICE))
        # the arrays are kept alive as long as what runs on them
        kept = (graph, inputs, outputs)

        @shares_warp
        def run() -> None:
            wp.capture_launch(kept[0])

        return run


def _begins(shapes: Mapping[str, Shape]) -> tuple[list[int], int]:
    """Where each array begins, and the length of all."""
    begins, length = [], 0
    for shape in shapes.values():
        begins.append(length)
        length += -(-math.prod(shape) // LINE) * LINE
    return begins, length


def _views(
    whole: npt.NDArray[Number], begins: list[int], shapes: Mapping[str, Shape]
) -> dict[str, npt.NDArray[Number]]:
    """The array of each name and shape within the whole."""
    return {
        name: whole[begin : begin + math.prod(shape)].reshape(shape)
        for begin, (name, shape) in zip(begins, shapes.items(), strict=True)
    }
