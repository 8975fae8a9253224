"""Device arrays that hold nothing from one step to the next, shared by those who step in turn."""

from __future__ import annotations

from typing import Any

from warp_softbody.device.allocator import Allocator, DeviceArray

Shape = int | tuple[int, ...]


class Workspace:
    """Work arrays of one stepper, or of many that never step at the same time.

    What is worked in stays in the processor's caches then, and many copies of a body need little
    more memory than their states and factors.
    """

    def __init__(self) -> None:
        """No arrays yet."""
        self._arrays: dict[tuple[object, ...], DeviceArray] = {}

    def part(self, name: str, make: Allocator) -> WorkPart:
        """A part of it for one kind of work, to be laid out anew by every owner."""
        return WorkPart(self._arrays, name, make)


class WorkPart:
    """Hands out a workspace's arrays in the order in which they are asked for."""

    def __init__(
        self, arrays: dict[tuple[object, ...], DeviceArray], name: str, make: Allocator
    ) -> None:
        """Begin with the first array of the part of this name."""
        self._arrays = arrays
        self._name = name
        self._make = make
        self._count = 0

    def zeros(self, shape: Shape, dtype: Any) -> DeviceArray:
        """The next array: that of the owners before where it is alike, else one of zeros.

        An owner writes it in every step before reading it, as others may have in between.
        """
        key = (self._name, self._count, self._make.device, shape, dtype)
        self._count += 1
        if key not in self._arrays:
            self._arrays[key] = self._make.zeros(shape, dtype)
        return self._arrays[key]
