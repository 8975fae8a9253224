"""The process of a command line ends at once when all is said, with its exit code."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

PROGRAM = """
import atexit, ctypes
from warp_softbody import __main__, cli

class Kept:
    def __del__(self):
        print("taken apart")

def main():
    atexit.register(print, "last words")
    ctypes.CDLL(None).printf(b"said by C, ")
    {}

kept = Kept()
cli.main = main
__main__.program()
"""


def ended(body: str) -> tuple[int, str, str]:
    """Exit code, standard output and the last line of standard error of such a program."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(body)], cwd=ROOT, capture_output=True, text=True
    )
    return done.returncode, done.stdout, done.stderr.strip().rpartition("\n")[2]


def test_what_was_said_arrives_and_nothing_is_taken_apart() -> None:
    code, out, err = ended("return 3")
    # Python has its own buffer, and C one that is written behind it
    assert (code, sorted(out.replace(", ", "\n").splitlines()), err) == (
        3,
        ["last words", "said by C"],
        "",
    )


def test_an_error_ends_it_as_usual() -> None:
    code, out, err = ended('raise RuntimeError("a mistake of ours")')
    assert (code, err) == (1, "RuntimeError: a mistake of ours")
    assert "last words" in out and "taken apart" in out
