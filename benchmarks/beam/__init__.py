"""The benchmark ``python -m benchmarks.beam``."""
