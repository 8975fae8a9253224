"""Timings, as ratios within one run: ``python -m benchmarks.beam`` from the repository root."""
