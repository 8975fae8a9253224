"""``python -m benchmarks.stability``."""

from benchmarks.stability.command import main

main()
