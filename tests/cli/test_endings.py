"""Runs that end early: Ctrl-C, numbers that are not finite, a reader that goes away."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warp_softbody.cli.interruption import Interrupted, Interruption, held_back, interruptible
from warp_softbody.stage_exports import read_take, validate


def started_take(start: Any, out: Path) -> Any:
    """A long run that has closed a chunk of its stage."""
    process = start("run", "topple-i", "--seconds", 9e4, "--fps", 100, "--json", "--out", out)
    deadline = time.monotonic() + 60.0
    while not list(out.parent.glob(f".{out.name}.chunks/frames_*")):
        assert time.monotonic() < deadline and process.poll() is None, process.communicate()
        time.sleep(0.02)
    return process


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_interrupted_run_leaves_a_valid_stage(start: Any, tmp_path: Path, name: str) -> None:
    out = tmp_path / "take.usdc"
    process = started_take(start, out)
    process.send_signal(signal.Signals[name])
    out_text, err_text = process.communicate(timeout=60)
    summary = json.loads(out_text)
    code = 128 + signal.Signals[name]
    assert (process.returncode, err_text, summary["status"]) == (code, "", "interrupted")
    assert len(read_take(out)) == summary["frames"] >= 120
    assert validate(out) == []
    assert [path.name for path in tmp_path.iterdir()] == ["take.usdc"]


def test_a_killed_run_is_recovered_and_a_live_one_is_left(
    start: Any, call: Any, tmp_path: Path
) -> None:
    out = tmp_path / "take.usdc"
    process = started_take(start, out)
    for command in (("recover", out), ("run", "topple-i", "--seconds", 0.1, "--out", out)):
        answer = call(*command)
        assert (answer.code, answer.out, answer.err.count("\n")) == (2, "", 1), answer
        assert "being written" in answer.err or f"process {process.pid}" in answer.err
    process.kill()
    process.communicate()
    out.write_text("somebody else's")
    answer = call("recover", out)
    assert answer.code == 2 and "take.usdc' stays as it is" in answer.err and "--out" in answer.err
    other = tmp_path / "other.usdc"
    answer = call("recover", out, "--out", other, "--json")
    told = json.loads(answer.out)
    assert (answer.code, answer.err, told["stage"]) == (0, "", str(other))
    assert len(read_take(other)) == told["frames"] >= 120 and validate(other) == []
    assert out.read_text() == "somebody else's"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other.usdc", "take.usdc"]
    answer = call("recover", out)
    assert answer.code == 2 and "nothing to recover" in answer.err


def test_signals_that_are_ignored_stay_so() -> None:
    """As under `nohup`; afterwards everything is as before."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.getsignal(number) for number in numbers]
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interruptible():
            signal.raise_signal(signal.SIGHUP)
            with pytest.raises(Interrupted) as caught:
                signal.raise_signal(signal.SIGTERM)
        assert caught.value.number == signal.SIGTERM
    finally:
        signal.signal(signal.SIGHUP, before[2])
    assert [signal.getsignal(number) for number in numbers] == before


def test_a_second_interrupt_does_not_wait() -> None:
    before = signal.getsignal(signal.SIGINT)
    with Interruption() as interruption:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        assert not interruption.asked
        interruption.patient = True
        signal.raise_signal(signal.SIGINT)
        assert interruption.asked
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_signals_wait_while_they_would_be_swallowed() -> None:
    done = []
    with interruptible(), pytest.raises(Interrupted):
        with held_back():
            with held_back():
                signal.raise_signal(signal.SIGTERM)
            done.append("inner")
        done.append("outer")
    assert done == ["inner"]
    with interruptible(), held_back():
        pass


def test_frames_before_a_run_that_cannot_go_on_are_kept(call: Any, tmp_path: Path) -> None:
    """A slab slides without friction until float32 cannot tell its nodes apart."""
    out = tmp_path / "slab.usdc"
    far = ("--time-step", 10, "--fps", 0.1, "--seconds", 2000, "--precision", "float32")
    answer = call("run", "slope", "--set", "friction=0", *far, "--json", "--out", out)
    summary = json.loads(answer.out)
    assert (answer.code, summary["status"]) == (3, "not finite")
    assert 20 < summary["frames"] < 200
    (sentence,) = [line for line in answer.err.splitlines() if "in doubt" not in line]
    step = summary["frames"] - 1
    assert f"too far away for float32 to tell them apart at step {step}" in sentence
    take = read_take(out)
    assert len(take) == summary["frames"] and np.isfinite(take.tet_points).all()


def test_broken_pipe_is_not_an_error(start: Any) -> None:
    process = start("list")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(timeout=60) == 141
