"""`python -m warp_softbody` is `warp-softbody`: a process that runs one command line and ends."""

from __future__ import annotations

import gc
import os
import sys
from typing import NoReturn

SELDOM = 100_000
"""New objects until the collector of garbage looks at them.

Loading libraries and kernels makes a million that all stay."""


def program() -> NoReturn:
    """Run the command line of this process and end it."""
    gc.set_threshold(SELDOM)
    # a step's small products take longer on several threads, which then wait in a loop for more;
    # read by NumPy when it is loaded
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from warp_softbody.cli import main

    code = main()
    # what is left ends with the process, and need not be looked through once more
    gc.freeze()
    sys.exit(code)


if __name__ == "__main__":
    program()
