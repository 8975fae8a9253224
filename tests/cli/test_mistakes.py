"""What the user got wrong: one sentence, exit code 2, and nothing on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from warp_softbody.inputs import extras

MISTAKES = {
    "rum": "COMMAND: invalid choice: 'rum'",
    "run": "required: NAME",
    "run balnce-i": "there is no scene 'balnce-i'; did you mean 'balance-i'?",
    "run balance-i --time-step -1": "--time-step: must be a finite number of s from 1e-09",
    "run balance-i --time-step nan": "--time-step: must be a finite number of s",
    "run balance-i --seconds inf": "--seconds: must be a number",
    "run balance-i --seconds soon": "--seconds: must be a number from 0.001 to 100000 s",
    "run balance-i --seconds 0.01": "--seconds 0.01 is less than half a frame at --fps 30",
    "run balance-i --fps 0": "--fps: must be a number from 0.1 to 10000, got '0'",
    "run balance-i --precision half": "--precision: invalid choice: 'half'",
    "run balance-i --device gpu7": '--device: must be "cpu", "cuda" or "cuda:0", not \'gpu7\'',
    "run balance-i --device cuda:7": "there is no device 'cuda:7' here; known: cpu",
    "run topple-i --max-qps 3": "--max-qps is for a controller, and nothing drives 'topple-i' here",
    "run balance-i --controller pid": "--controller: invalid choice: 'pid'",
    "run topple-i --controller qpcc": "scene 'topple-i' has no controller",
    "run balance-i --set pusk=1": "has no setting 'pusk'; did you mean 'push'? known: push,",
    "run balance-i --set push=hard": "'push' must be a number from -2 to 2 body weights",
    "run balance-i --set push=nan": "'push' must be a number from -2 to 2 body weights",
    "run balance-i --set friction=-1": "'friction' must be a number from 0 to 10, got '-1'",
    "run balance-i --set push": "--set: must be key=value, got 'push'",
    "run balance-i --set push=1 --set push=2": "--set gives 'push' twice: '1' and '2'",
    "run balance-i --sec 1": "unrecognized arguments: --sec 1",
    "run balance-i --out absent/i.usdc": "there is no folder",
    "run balance-i --out i.obj": "must end in one of .usdc, .usda, .usd",
    "run balance-i --out /proc/i.usdc": "cannot write in the folder '/proc'",
    "run balance-i --out i.usdc --picture i.jpg": "must end in one of .png",
    "run balance-i --out i.usdc --movie i.avi": "must end in one of .gif, .mp4",
    "run balance-i --movie z.gif --plots ./z.gif": "--plots and --movie are both 'z.gif'",
    "run balance-i --picture .": "must end in one of .png",
    "run body.obj": "body.obj is a shape and no scene; `warp-softbody character body.obj -o",
    "run absent.char": "absent.char: there is no such file",
    "character absent.obj -o a.char": "absent.obj: there is no such file",
    "character absent.obj -o a.char --unit cm --height 1": "--height: not allowed with",
    "mesh absent.stl -o out.vtu": "there is no such file",
}


@pytest.mark.parametrize("line", MISTAKES)
def test_one_sentence_and_nothing_on_disk(
    call: Any, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = call(*line.split())
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("warp-softbody: ") and answer.err.count("\n") == 1
    assert MISTAKES[line] in answer.err
    assert not list(tmp_path.iterdir())


def test_missing_packages_are_told_before_the_run(
    call: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(extras, "find_spec", lambda name: None)
    files = ("--out", tmp_path / "i.usdc", "--picture", tmp_path / "i.png")
    answer = call("run", "balance-i", *files)
    assert answer.code == 2 and "pip install 'warp-softbody[view]'" in answer.err
    assert not list(tmp_path.iterdir())
