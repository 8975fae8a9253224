"""``python -m benchmarks.qpcc``."""

from benchmarks.qpcc.command import main

main()
