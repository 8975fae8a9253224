"""A standard error that takes nothing does not change how a command ends."""

from __future__ import annotations

import subprocess
import sys


def test_full_stderr_keeps_the_code() -> None:
    command = '"$0" -m warp_softbody run nope 2>/dev/full'
    assert subprocess.run(["bash", "-c", command, sys.executable], check=False).returncode == 2
