"""The tables of docs/frontier.md, from the charts' files: ``python -m benchmarks.charts``."""
