"""``python -m benchmarks.motions``."""

from benchmarks.motions.command import main

main()
