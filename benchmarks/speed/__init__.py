"""The benchmark ``python -m benchmarks.speed``."""
