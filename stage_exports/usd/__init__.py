"""USD stages are written, read and checked in this room; only it imports `pxr`."""
