"""The control problem of a step solved by native code, with the NumPy form as its reference."""
