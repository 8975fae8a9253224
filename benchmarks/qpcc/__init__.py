"""How near the QPCC solver comes to the optimum, and how fast: ``python -m benchmarks.qpcc``."""
