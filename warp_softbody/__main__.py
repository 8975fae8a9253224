"""`python -m warp_softbody` is `warp-softbody`: a process that runs one command line and ends."""

from __future__ import annotations

import atexit
import gc
import os
import sys
from contextlib import suppress
from typing import NoReturn

SELDOM = 100_000
"""New objects until the collector of garbage looks at them.

Loading libraries and kernels makes a million that all stay."""

_ended: list[int] = []
"""The exit code, once the command line has come to its end."""


def program() -> NoReturn:
    """Run the command line of this process and end it."""
    gc.set_threshold(SELDOM)
    # a step's small products take longer on several threads, which then wait in a loop for more;
    # read by NumPy when it is loaded
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if _alone():
        # the first to be registered is the last to be called, when threads and libraries are done
        atexit.register(_leave)
    from warp_softbody.cli import main

    code = main()
    _ended.append(code)
    sys.exit(code)


def _alone() -> bool:
    """Whether nothing but the command line lives in this process.

    A program that calls it has files and an exit code of its own. What others want done at the end
    (coverage, site customisations) and have asked for before would come after `_leave`.
    """
    if atexit._ncallbacks() > 0:
        return False
    begun = vars(sys.modules["__main__"])
    # run by `python -m`, or by the script that pip has made
    return begun is globals() or os.path.basename(begun.get("__file__", "")) == "warp-softbody"


def _leave() -> None:
    """End here: taking a million objects apart one by one would take 50 ms, and to no purpose.

    An error that is on its way out ends the process as usual.
    """
    if not _ended:
        return
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, OSError, ValueError):
            stream.flush()
    # what kernels have printed by way of C
    libraries = sys.modules.get("ctypes")
    if libraries is not None and os.name == "posix":
        libraries.CDLL(None).fflush(None)
    os._exit(_ended[0])


if __name__ == "__main__":
    program()
