"""The sparse linear system of a step: its pattern, its solver and its preconditioners."""
