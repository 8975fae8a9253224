"""Extreme cases: what other programs do and what ours does, as a table."""
