"""Output that is full or closed: one sentence and a code, never a traceback."""

from __future__ import annotations

import subprocess
import sys

import pytest

LIST = [sys.executable, "-m", "warp_softbody", "list"]


def shell(redirection: str) -> subprocess.CompletedProcess[str]:
    command = f'"$0" "$@" {redirection}'
    return subprocess.run(
        ["bash", "-c", command, *LIST], capture_output=True, text=True, check=False
    )


def test_full_stdout() -> None:
    ended = shell(">/dev/full")
    assert ended.returncode == 2
    assert ended.stderr == "warp-softbody: output could not be written: No space left on device\n"


@pytest.mark.parametrize("redirection", [">&-", ">&- 2>&- <&-"])
def test_closed_streams(redirection: str) -> None:
    ended = shell(redirection)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")


def test_full_stderr_keeps_the_code() -> None:
    command = '"$0" -m warp_softbody run nope 2>/dev/full'
    assert subprocess.run(["bash", "-c", command, sys.executable], check=False).returncode == 2
