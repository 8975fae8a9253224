"""A process that does a work on one thread and tells its CPU time: ``python -m ... WORK PROGRAM``.

It reads a number of steps a line and answers with the CPU time, s, that they took. With a third
argument, the root of another checkout, it is that checkout's `warp_softbody` that is timed.
"""

from __future__ import annotations

import sys
import time

import benchmarks.speed.works as known


def main(arguments: list[str]) -> None:
    """Make the work, say so, and take steps as asked."""
    work, program, *roots = arguments
    sys.path[:0] = roots
    answers = sys.stdout
    # programs that print as they go do not reach the parent
    sys.stdout = sys.stderr
    step = known.works()[work].make(program)
    print("ready", file=answers, flush=True)
    for line in sys.stdin:
        begun = time.process_time()
        for _ in range(int(line)):
            step()
        print(time.process_time() - begun, file=answers, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
