"""Runs that end early: Ctrl-C, numbers that are not finite, a reader that goes away."""

from __future__ import annotations

import json
import signal
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from warp_softbody.cli.interruption import Interruption
from warp_softbody.stage_exports import read_take, validate
from warp_softbody.stepper import Stepper


def test_interrupted_run_leaves_a_valid_stage(start: Any, tmp_path: Path) -> None:
    out = tmp_path / "take.usdc"
    process = start("run", "topple-i", "--seconds", 9e4, "--fps", 100, "--json", "--out", out)
    deadline = time.monotonic() + 60.0
    while not list(tmp_path.glob(".take.usdc.chunks/frames_*")):
        assert time.monotonic() < deadline and process.poll() is None, process.communicate()
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out_text, err_text = process.communicate(timeout=60)
    summary = json.loads(out_text)
    assert (process.returncode, err_text, summary["status"]) == (130, "", "interrupted")
    assert len(read_take(out)) == summary["frames"] >= 120
    assert validate(out) == []
    assert [path.name for path in tmp_path.iterdir()] == ["take.usdc"]


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


def test_frames_before_a_number_that_is_not_finite_are_kept(
    call: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settle, steps = Stepper.resolve_contact, []

    def fails_at_step_10(stepper: Stepper, *arguments: Any) -> Any:
        steps.append(1)
        return replace(settle(stepper, *arguments), finite=len(steps) < 10)

    monkeypatch.setattr(Stepper, "resolve_contact", fails_at_step_10)
    out = tmp_path / "i.usdc"
    answer = call("run", "topple-i", "--time-step", 1 / 120, "--json", "--out", out)
    summary = json.loads(answer.out)
    assert (answer.code, summary["status"], summary["frames"]) == (3, "not finite", 3)
    assert answer.err.count("\n") == 1 and "stopped being finite at step 9" in answer.err
    assert len(read_take(out)) == 3


def test_broken_pipe_is_not_an_error(start: Any) -> None:
    process = start("list")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(timeout=60) == 141
