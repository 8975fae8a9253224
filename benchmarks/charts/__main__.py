"""``python -m benchmarks.charts``."""

from benchmarks.charts.command import main

main()
