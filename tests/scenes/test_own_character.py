"""What a character of a file can be asked to do on the command line."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import pytest

from tests.support.surfaces import BODIES
from warp_softbody import Character, scene_files, scenes
from warp_softbody.cli import main
from warp_softbody.controllers import Sequence
from warp_softbody.errors import InputError, MeshWarning


@pytest.fixture(scope="module")
def ring(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("own") / "ring.char"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        Character.from_surface(BODIES["torus"](), name="ring", tets=600).save(path)
    return path


@pytest.mark.parametrize("do", ["balance", "walk", "jump", "hop", "roll"])
def test_does_what_it_is_asked(ring: Path, do: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(ring), "--do", do, "--seconds", "0.1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["controller"] == "qpcc"


def test_settings_are_those_of_the_motion(ring: Path) -> None:
    plan = scenes.make(str(ring), {"heading": 1.0, "speed": 0.1}, do="walk")
    assert plan.settings["push"] == 0.0
    assert plan.description == "ring walks"
    with pytest.raises(InputError, match="has no setting 'heading'"):
        scenes.make(str(ring), {"heading": 1.0}, do="jump")


def test_several_things_in_turn(
    ring: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = scenes.make(str(ring), {"height": 0.05}, do="walk:0.1s, jump,walk: 2 m")
    assert isinstance(plan.controller, Sequence)
    assert [motion.title for motion in plan.controller.motions] == ["walk", "jump", "walk"]
    assert plan.controller.motions[2].distance == 2.0
    assert "push" in plan.settings and plan.settings["push"] == 0.0
    line = ["run", str(ring), "--do", "walk:0.1s,balance", "--seconds", "0.2", "--json"]
    assert main(line) == 0
    motions = json.loads(capsys.readouterr().out)["motions"]
    assert [motion["name"] for motion in motions] == ["walk", "balance"]
    # and as a file, whose motions are the same
    file = tmp_path / "both.toml"
    assert main(["new", str(file), "--from", str(ring), "--do", "walk:0.1s,balance"]) == 0
    read = scene_files.read(file).plan.controller
    assert isinstance(read, Sequence)
    assert [motion.title for motion in read.motions] == ["walk", "balance"]


@pytest.mark.parametrize(
    ("do", "sentence"),
    [
        ("walk,balance", "to walk never ends, but something else is to follow"),
        ("walk:2km,balance", "must end after metres or seconds, as walk:2m"),
        ("walk:0s,balance", "must end after metres or seconds"),
        ("walk:2m,,balance", "what a character does must be one of"),
        ("", "what a character does must be one of"),
    ],
)
def test_what_does_not_follow_is_told(ring: Path, do: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        scenes.make(str(ring), do=do)


def test_what_it_cannot_do_is_told(ring: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(ring), "--do", "crawl"]) == 2
    assert "Crawl needs a body that lies" in capsys.readouterr().err
    with pytest.raises(InputError, match="what a character does must be one of"):
        scenes.make(str(ring), do="fly")
    assert main(["run", "stack", "--do", "walk"]) == 2
    assert "--do is for the character of a file" in capsys.readouterr().err
