"""Checks of what a caller gives, and records that hold arrays."""
