"""``python -m benchmarks.robustness``."""

from benchmarks.robustness.command import main

main()
