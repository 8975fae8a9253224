"""The one tree of errors.

Every error is one clear sentence that names the file, the field and the value at fault; the command
line prints exactly that sentence and exits with code 2.
"""

from __future__ import annotations


class SoftBodyError(Exception):
    """Root of every error that this package raises on purpose."""


class InputError(SoftBodyError, ValueError):
    """A value given by the user cannot be used: an option, a field of a dataclass, a scene name."""


class MeshError(InputError):
    """A mesh or surface cannot be used: unreadable, open, not finite, in several parts, empty."""


class MeshWarning(UserWarning):
    """A mesh or surface was taken, but not all that its file holds; the sentence says what not."""


class OutputError(SoftBodyError, OSError):
    """A file or folder cannot be written. Nothing half-written is left behind."""


class NotFiniteError(SoftBodyError, ArithmeticError):
    """Numbers stopped being finite during a simulation.

    Attributes:
        step: index of the step at which it happened.
        time: simulated time in s at the start of that step.
    """

    def __init__(self, message: str, *, step: int, time: float) -> None:
        """Keep the step and time beside the sentence."""
        super().__init__(message)
        self.step = step
        self.time = time


class MissingExtraError(SoftBodyError, ImportError):
    """An optional dependency is not installed; the sentence says which extra brings it."""
