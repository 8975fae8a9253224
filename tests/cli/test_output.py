"""An output that nobody takes: one sentence, a code that tells it, and the files all the same."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from warp_softbody.stage_exports import read_take

ROOT = Path(__file__).parents[2]
LOST = "warp-softbody: standard output could not be written: "
RUN = "run topple-i --seconds 0.1 --out take.usdc"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.parametrize(
    ("line", "code", "err"),
    [
        (f"{RUN} > /dev/full", 2, LOST + "No space left on device\n"),
        (f"{RUN} >&-", 2, LOST + "Bad file descriptor\n"),
        (f"{RUN} <&- >&- 2>&-", 2, ""),
        (f"{RUN} --quiet >&-", 0, ""),
        (f"{RUN} | true", 141, ""),
        ("--help > /dev/full", 2, LOST + "No space left on device\n"),
        ("list > /dev/full", 2, LOST + "No space left on device\n"),
        ("run nosuch 2> /dev/full", 2, ""),
        ("run nosuch 2>&-", 2, ""),
    ],
)
def test_output_that_is_lost(tmp_path: Path, line: str, code: int, err: str) -> None:
    script = f"set -o pipefail; {sys.executable} -m warp_softbody {line}"
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])},
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (code, "", err)
    if line.startswith(RUN):
        assert len(read_take(tmp_path / "take.usdc")) == 4
