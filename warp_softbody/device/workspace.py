"""Device arrays that hold nothing from one step to the next, shared by those who step in turn."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from warp_softbody.device.allocator import Allocator, DeviceArray

Shape = int | tuple[int, ...]
Made = TypeVar("Made")


class Workspace:
    """Work arrays of one stepper, or of many that never step at the same time.

    What is worked in stays in the processor's caches then, and many copies of a body need little
    more memory than their states and factors.
    """

    def __init__(self) -> None:
        """No arrays yet."""
        self._arrays: dict[tuple[object, ...], DeviceArray] = {}
        self._shared: dict[tuple[Hashable, ...], tuple[Any, tuple[object, ...]]] = {}

    def shared(
        self,
        name: str,
        values: tuple[Hashable, ...],
        objects: tuple[object, ...],
        make: Callable[[], Made],
    ) -> Made:
        """What ``make`` makes, once for all owners that name it by the same values and objects.

        It may be what follows from these alone and never changes, or what holds nothing from one
        use to the next. Objects are told apart by identity, and kept alive.
        """
        key = (name, *values, *map(id, objects))
        if key not in self._shared:
            self._shared[key] = (make(), objects)
        found: Made = self._shared[key][0]
        return found

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
