"""An `Allocator` makes device arrays in the types of a precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.kernels.precision import Real

DeviceArray: TypeAlias = Any
"""A Warp array: its element type hangs on the precision, so what it holds is said where it stands.

``scalar``, ``vec3`` and ``mat33`` are those of the precision, ``vec3d`` is always double.
"""


def constant_integers(
    values: npt.NDArray[np.integer], dtype: Any = wp.int32, device: str = "cpu"
) -> DeviceArray:
    """A device array of integers that are never written; on the CPU it shares their memory."""
    contiguous = np.ascontiguousarray(values, dtype=np.int32)
    return wp.array(contiguous, dtype=dtype, device=device, copy=False)


@dataclass(frozen=True)
class Allocator:
    """Makes device arrays in the types of a precision."""

    types: Real
    device: str

    def array(self, values: npt.ArrayLike, dtype: Any) -> DeviceArray:
        """A device array of values."""
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=self.device)

    def indices(self, values: npt.NDArray[np.integer], dtype: Any = wp.int32) -> DeviceArray:
        """A device array of constant integers; on the CPU it shares their memory."""
        return constant_integers(values, dtype, self.device)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any) -> DeviceArray:
        """A device array of zeros."""
        return wp.zeros(shape, dtype=dtype, device=self.device)
