"""Device arrays read on the host in every step."""

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
