"""USD stages, out and back in."""
