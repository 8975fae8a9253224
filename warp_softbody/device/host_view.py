"""A `HostView` reads and writes a small device array in every step, on the CPU without a copy."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt


class HostView:
    """A small device array as NumPy sees it; on the CPU the memory is shared, and nothing copied.

    Making such a view takes longer than a small step's kernel, so it is made once.
    """

    def __init__(self, array: Any) -> None:
        """View a device array for as long as it lives."""
        self._array = array
        self._shared: npt.NDArray[Any] | None = array.numpy() if array.device.is_cpu else None

    def read(self) -> npt.NDArray[Any]:
        """What the array holds now; not to be kept, since it may change with the next step."""
        if self._shared is not None:
            return self._shared
        copy: npt.NDArray[Any] = self._array.numpy()
        return copy

    def write(self, values: npt.NDArray[Any]) -> None:
        """Let the array hold values of its shape, in its precision."""
        if self._shared is not None:
            self._shared[...] = values
        else:
            self._array.assign(values)


class HostViews:
    """Views of the arrays that a caller hands in again and again, found by their identity."""

    def __init__(self) -> None:
        """No views yet."""
        self._views: dict[int, tuple[Any, HostView]] = {}

    def read(self, array: Any) -> npt.NDArray[Any]:
        """What an array holds now; see `HostView.read`."""
        return self._view(array).read()

    def write(self, array: Any, values: npt.NDArray[Any]) -> None:
        """Let an array hold values of its shape; see `HostView.write`."""
        self._view(array).write(values)

    def _view(self, array: Any) -> HostView:
        found = self._views.get(id(array))
        if found is None:
            # the array is kept alive, so that its identity is not used again
            found = self._views[id(array)] = (array, HostView(array))
        return found[1]
