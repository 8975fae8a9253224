"""``python -m benchmarks.beam``."""

from benchmarks.beam.command import main

main()
