"""Warp is started, shared between threads and read from NumPy in this room."""
