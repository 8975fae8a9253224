"""A module with next to nothing in it, whose compilation leaves Warp's header precompiled."""

from functools import cache
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "header"


@cache
def make_header() -> SimpleNamespace:
    """The kernel that does nothing."""
    kernel: Any = real("float32").kernel(SUBJECT)

    @kernel
    def nothing(
        # in
        count: wp.int32,
    ):
        pass

    return SimpleNamespace(nothing=nothing)
