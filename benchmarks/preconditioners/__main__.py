"""``python -m benchmarks.preconditioners``."""

from benchmarks.preconditioners.command import main

main()
