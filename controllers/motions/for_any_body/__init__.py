"""Motions that any body can be asked for: each finds out from its shape how it may go."""
