"""Python processes that a test starts and ends by signals."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]
_TAKES_SIGNALS = (
    "import os, signal, sys\n"
    "for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):\n"
    "    signal.signal(number, signal.SIG_DFL)\n"
    "os.execv(sys.executable, [sys.executable, *sys.argv[1:]])"
)


def start_python(
    *arguments: object,
    environment: Mapping[str, str] | None = None,
    stdout: int | None = None,
    stderr: int | None = None,
    new_session: bool = False,
) -> subprocess.Popen[str]:
    """Start Python on this checkout, so that SIGINT, SIGTERM and SIGHUP reach it as in a terminal.

    A suite in the background or under nohup ignores some of them, which its processes inherit.

    Args:
        arguments: of the interpreter.
        environment: variables beside those of this process.
        stdout: as in `subprocess.Popen`.
        stderr: likewise.
        new_session: whether the process leads a group of its own, to be signalled as a whole.
    """
    path = os.pathsep.join([str(ROOT), *sys.path])
    return subprocess.Popen(
        [sys.executable, "-c", _TAKES_SIGNALS, *map(str, arguments)],
        stdout=stdout,
        stderr=stderr,
        text=True,
        start_new_session=new_session,
        env={**os.environ, "PYTHONPATH": path, **(environment or {})},
    )
