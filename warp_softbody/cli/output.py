"""What the command line prints; an output that nobody takes does not end the work.

A reader may go away (`| head -1`), a disk may be full (`> /dev/full`), or a stream may be closed
(`>&-`). What is lost is remembered and told at the end.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

BROKEN_PIPE = 141
FAILED = 2

_lost: list[OSError | ValueError] = []


def say(text: str) -> None:
    """Print lines on standard output, now; whether they arrived is for `finish` to tell."""
    if _lost:
        return
    try:
        print(text, flush=True)
    except (OSError, ValueError) as error:
        _lost.append(error)


def complain(text: str) -> None:
    """Print one line on standard error, whatever line breaks a library has put into it."""
    note(f"warp-softbody: {' '.join(text.split())}\n")


def note(text: str) -> None:
    """Print something on standard error, where somebody takes it."""
    with suppress(OSError, ValueError):
        print(text, end="", file=sys.stderr, flush=True)


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Inside the body each warning for the user is told once, as one line on standard error.

    What `python -W` says of warnings holds.
    """
    told: set[str] = set()

    def show(message: Warning | str, *_: object) -> None:
        if str(message) not in told:
            told.add(str(message))
            complain(str(message))

    with warnings.catch_warnings():
        if not sys.warnoptions:
            warnings.simplefilter("always", UserWarning)
        warnings.showwarning = show  # type: ignore[assignment]
        yield


def begin() -> None:
    """Fill closed standard streams, so that no file that is opened takes their place."""
    _lost.clear()
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            # opened for reading, standard output fails as a closed stream does
            os.open(os.devnull, os.O_RDWR if name == "stderr" else os.O_RDONLY)
            if number and getattr(sys, name) is None:
                stream = os.fdopen(number, "w", closefd=False, errors="backslashreplace")
                setattr(sys, name, stream)
    # a file name that the terminal's encoding lacks
    with suppress(AttributeError):
        sys.stdout.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


def finish(code: int) -> int:
    """The exit code of a command that ended with ``code``, once its output has arrived or not.

    A reader that has gone is no mistake, and told by the code alone.
    """
    try:
        sys.stdout.flush()
    except (OSError, ValueError) as error:
        _lost.append(error)
    try:
        sys.stderr.flush()
    except (OSError, ValueError):
        _drop(sys.stderr)
    if not _lost:
        return code
    first = _lost[0]
    _drop(sys.stdout)
    if isinstance(first, BrokenPipeError):
        return code or BROKEN_PIPE
    cause = first.strerror if isinstance(first, OSError) else str(first)
    complain(f"standard output could not be written: {cause}")
    return code or FAILED


def _drop(stream: TextIO) -> None:
    """Let what is left in a stream go nowhere, so that the interpreter ends without a word."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        stream.flush()
