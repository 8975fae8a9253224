"""The process of a command line ends at once when all is said, with its exit code."""

from __future__ import annotations

import os
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


def ended(body: str, folder: Path, *, name: str = "warp-softbody") -> tuple[int, str, str]:
    """Exit code, standard output and the last line of standard error of such a script."""
    script = folder / name
    script.write_text(PROGRAM.format(body))
    environment = os.environ | {"PYTHONPATH": f"{folder}{os.pathsep}{ROOT}"}
    done = subprocess.run(
        [sys.executable, str(script)], cwd=ROOT, env=environment, capture_output=True, text=True
    )
    return done.returncode, done.stdout, done.stderr.strip().rpartition("\n")[2]


def test_what_was_said_arrives_and_nothing_is_taken_apart(tmp_path: Path) -> None:
    code, out, err = ended("return 3", tmp_path)
    # Python has its own buffer, and C one that is written behind it
    assert (code, sorted(out.replace(", ", "\n").splitlines()), err) == (
        3,
        ["last words", "said by C"],
        "",
    )


def test_an_error_ends_it_as_usual(tmp_path: Path) -> None:
    code, out, err = ended('raise RuntimeError("a mistake of ours")', tmp_path)
    assert (code, err) == (1, "RuntimeError: a mistake of ours")
    assert "last words" in out and "taken apart" in out


def test_a_program_that_runs_a_command_line_ends_as_usual(tmp_path: Path) -> None:
    """It has files to close and an exit code of its own."""
    code, out, err = ended("return 3", tmp_path, name="script.py")
    assert (code, err) == (3, "")
    assert "last words" in out and "taken apart" in out


def test_what_was_asked_for_before_is_done_at_the_end(tmp_path: Path) -> None:
    """Coverage of a child process is written so."""
    (tmp_path / "sitecustomize.py").write_text(
        "import atexit\natexit.register(print, 'the last')\n"
    )
    code, out, err = ended("return 3", tmp_path)
    assert (code, err) == (3, "")
    assert "last words" in out and "the last" in out
