"""`warp-softbody new`, `check` and `run` with scene files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from warp_softbody.cli import main


def test_from_nothing_to_a_stage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "my.toml"
    assert main(["new", str(file)]) == 0
    text = (
        file.read_text().replace("seconds = 4.0", "seconds = 0.1").replace("# [output]", "[output]")
    )
    file.write_text(text.replace('# stage = "', 'stage = "'))
    assert main(["check", str(file), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert facts["controller"] == "Balance" and len(facts["bodies"]) == 3
    assert main(["run", str(file), "--quiet"]) == 0
    assert (tmp_path / "my.usdc").exists()


def test_a_shipped_scene_as_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "my.toml"
    assert main(["new", str(file), "--from", "stack", "--set", "count=2"]) == 0
    assert main(["check", str(file)]) == 0
    assert "cube_1: " in capsys.readouterr().out
    assert main(["new", str(file)]) == 2
    assert "is there already" in capsys.readouterr().err
    runs = []
    for name, more in ((str(file), []), ("stack", ["--set", "count=2"])):
        assert main(["run", name, "--seconds", "0.1", "--json", *more]) == 0
        runs.append(json.loads(capsys.readouterr().out))
    for key in ("steps", "iterations", "time_step", "seconds"):
        assert runs[0].get(key) == runs[1].get(key)


def test_warnings_are_one_line_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also those of a file that a run reads twice."""
    file = tmp_path / "my.toml"
    file.write_text(
        '[character]\nshape = "box"\nsize = [0.2, 0.2, 0.2]\ncells = [1, 1, 1]\n'
        '[controller]\nkind = "balance"\n'
    )
    assert main(["run", str(file), "--seconds", "0.05", "--quiet"]) == 0
    told = capsys.readouterr().err
    assert told == "warp-softbody: 'my' has no muscles, so its controller is never asked\n"


def test_a_summary_has_all_that_acts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "my.toml"
    file.write_text(
        '[character]\nshape = "box"\nsize = [0.2, 0.2, 0.2]\ncells = [1, 1, 1]\n'
        '[[movers]]\nname = "post"\nshape = "ball"\nradius = 0.1\ncenter = [2, 0, 0]\n'
        'path = { rate = 3 }\n[[fields]]\nkind = "uniform"\nacceleration = [1, 0, 0]\n'
    )
    assert main(["check", str(file)]) == 0
    told = capsys.readouterr().out
    assert "post: " in told and " kg, moved along a path\n" in told
    assert "0 pushes, 1 handle, 1 field, " in told


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["new", "a.json"], "must end in .toml"),
        (["new", "a.toml", "--set", "push=1"], "--set goes with --from"),
        (["new", "a.toml", "--from", "balance-j"], "did you mean 'balance-i'"),
        (["check", "none.toml"], "there is no such file"),
        (["run", "none.toml"], "there is no such file"),
        (["run", "none.toml", "--set", "push=1"], "--set is for scenes that ship"),
    ],
)
def test_mistakes_are_one_sentence(
    arguments: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert sentence in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
