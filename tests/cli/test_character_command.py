"""From a surface to a balancing character by two commands."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from trimesh import creation

from warp_softbody import Character
from warp_softbody.cli import main


@pytest.fixture
def surface(tmp_path: Path) -> Path:
    """A column on a plate, in cm, y up."""
    column, plate = creation.box((20, 80, 20)), creation.box((40, 10, 40))
    plate.apply_translation((0.0, -40.0, 0.0))
    path = tmp_path / "column.obj"
    (column + plate).export(path)
    return path


def test_makes_saves_and_describes(surface: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, picture = surface.with_name("c.char"), surface.with_name("c.png")
    line = ["character", str(surface), "-o", str(out), "--unit", "cm", "--up", "y", "--tets", "500"]
    assert main([*line, "--json", "--picture", str(picture)]) == 0
    said = capsys.readouterr()
    facts = json.loads(said.out)
    assert facts["height"] == pytest.approx(0.85, abs=0.02)
    assert facts["mass"] == pytest.approx(1000.0 * (0.2 * 0.2 * 0.8 + 0.4 * 0.4 * 0.1), rel=0.15)
    assert facts["repairs"] == ["2 parts united"]
    assert "2 parts united" in said.err
    assert picture.read_bytes().startswith(b"\x89PNG")
    character = Character.load(out)
    assert character.name == "column"
    assert character.segment_count == facts["segments"]


def test_a_body_that_may_lie_is_told(surface: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["character", str(surface), "-o", str(surface.with_name("c.char")), "--unit", "cm"]
    assert main([*line, "--tets", "300"]) == 0
    told = r"z was taken for up; if it lies and is to stand 0\.8\d* m high, give --up y"
    assert re.search(told, capsys.readouterr().out)
    assert main([*line, "--tets", "300", "--up", "z"]) == 0
    assert "taken for up" not in capsys.readouterr().out


def test_a_made_character_runs(surface: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = surface.with_name("c.char")
    line = ["character", str(surface), "-o", str(out), "--height", "0.9", "--up", "y"]
    assert main([*line, "--tets", "300", "--quiet"]) == 0
    capsys.readouterr()
    assert main(["run", str(out), "--seconds", "0.2", "--set", "push=0.1", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["scene"] == "column"
    assert facts["controller"] == "qpcc"


def test_a_flawed_surface_may_be_refused(surface: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = surface.with_name("c.char")
    assert main(["character", str(surface), "-o", str(out), "--unit=cm", "--repair=none"]) == 2
    assert "the surface is flawed, and repair is 'none'" in capsys.readouterr().err
    assert not out.exists()


def test_a_body_of_a_hundred_metres_is_asked_about(
    surface: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["character", str(surface), "-o", str(surface.with_name("c.char"))]) == 2
    assert "m high is hardly what is meant; give its unit" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["-o", "a.zip"], "must end in one of .char"),
        (["-o", "none/a.char"], "none"),
        (["-o", "a.char", "--picture", "a.gif"], "must end in one of .png"),
    ],
)
def test_names_are_checked_before_the_work(
    options: list[str], told: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """The surface, which is none, is not even read."""
    assert main(["character", str(tmp_path / "none.obj"), *options]) == 2
    said = capsys.readouterr().err
    assert "cannot write" in said and told in said
