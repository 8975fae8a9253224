"""Tuned settings on disk: checked when they are read, and before a sweep is made for them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from warp_softbody.accuracy.analysis import store
from warp_softbody.accuracy.analysis.tuned_checks import SETTINGS
from warp_softbody.accuracy.analysis.tuning import Tuned
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.cli import main
from warp_softbody.errors import InputError


def tuned(bound: float = 0.02) -> Tuned:
    return Tuned(
        scene="cantilever",
        given={},
        seconds=1.0,
        bound=bound,
        settings=Settings(time_step=1.0 / 60.0, cells=2),
        error=0.01,
        uncertainty=0.001,
        cost=3.0,
        default_cost=5.0,
        default_error=0.02,
        left_out=(),
        version="0.1.0",
    )


def stored(path: Path, **changes: Any) -> Path:
    """A file with one entry in which fields, or knobs of its settings, are changed."""
    values = tuned().to_dict()
    for name, value in changes.items():
        (values["settings"] if name in SETTINGS else values)[name] = value
    path.write_text(json.dumps([values]))
    return path


def test_every_knob_has_its_check() -> None:
    assert set(SETTINGS) == set(Settings(time_step=1.0).to_dict())


def test_what_is_saved_is_found_again(tmp_path: Path) -> None:
    path = tmp_path / "new" / "tuned.json"
    for bound in (0.02, 0.01, 0.02):
        store.save(tuned(bound), path)
    assert store.load(path) == [tuned(0.01), tuned(0.02)]
    assert [entry.name for entry in path.parent.iterdir()] == ["tuned.json"]
    assert len(store.load(store.SHIPPED)) > 3


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"time_step": 1e9}, "entry 0: time_step cannot be 1000000000.0"),
        ({"time_step": "fast"}, "time_step cannot be 'fast'"),
        ({"time_step": None}, "time_step cannot be None"),
        ({"time_step": True}, "time_step cannot be True"),
        ({"time_step": float("nan")}, "time_step cannot be nan"),
        ({"cells": 10**9}, "cells cannot be 1000000000"),
        ({"level": 30}, "level cannot be 30"),
        ({"threads": 10**9}, "threads cannot be 1000000000"),
        ({"newton_iterations": 1.5}, "newton_iterations cannot be 1.5"),
        ({"elements": ["linear"]}, r"elements cannot be \['linear'\]"),
        ({"tolerance": -1e-3}, "tolerance cannot be -0.001"),
        ({"elements": "smoothed", "tangent": "exact"}, "smoothed elements have no exact tangent"),
        ({"given": {"young_modulus": "soft"}}, "given cannot be"),
        ({"bound": 2.0}, "bound cannot be 2.0"),
        ({"settings": [1]}, r"settings cannot be \[1\]"),
        ({"settings": {}}, "has no 'time_step'"),
        ({"settings": {"time_step": 0.01, "knob": 1}}, "settings name the knob 'knob'"),
        ({"other": 1}, "has the field 'other', which is not known"),
        ({"left_out": "none"}, "left_out cannot be 'none'"),
    ],
)
def test_settings_that_cannot_be_are_refused(
    tmp_path: Path, changes: dict[str, Any], sentence: str
) -> None:
    path = stored(tmp_path / "tuned.json", **changes)
    with pytest.raises(InputError, match=sentence) as caught:
        store.load(path)
    assert f"'{path}' does not hold tuned settings: " in str(caught.value)


@pytest.mark.parametrize("text", ["", "{", "{}", "3", "null", "[3]", "[{}]", "\udcff", "[" * 5000])
def test_a_file_that_holds_something_else_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "tuned.json"
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(InputError, match="does not hold tuned settings"):
        store.load(path)


def test_links_beside_the_file_are_not_followed(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("precious")
    folder = tmp_path / "config"
    folder.mkdir()
    (folder / "tuned.json.part").symlink_to(victim)
    store.save(tuned(), folder / "tuned.json")
    assert victim.read_text() == "precious" and len(store.load(folder / "tuned.json")) == 1


def test_a_place_that_cannot_be_written_shows_before_the_sweep(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # the extra `charts` brings it
    pytest.importorskip("matplotlib")
    from warp_softbody.cli import chart_command, tune_command

    def never(args: object) -> None:
        raise AssertionError("a sweep has begun")

    monkeypatch.setattr(tune_command, "sweep_workers", never)
    monkeypatch.setattr(chart_command, "sweep_workers", never)
    (tmp_path / "file").write_text("[]")
    (tmp_path / "other.json").write_text("{}")
    tune = ("tune", "cantilever", "--error", "2%", "--out")
    for arguments, sentence in (
        ((*tune, "/proc/self/tuned.json"), "cannot write '/proc/self/tuned.json'"),
        ((*tune, tmp_path / "file" / "tuned.json"), "cannot write"),
        ((*tune, tmp_path), "does not hold tuned settings: Is a directory"),
        ((*tune, tmp_path / "other.json"), "does not hold tuned settings: it is no list"),
        (("chart", "cantilever", "--out", tmp_path / "file"), "cannot write into"),
        (("chart", "cantilever", "--out", "/proc/self/charts"), "cannot write into"),
    ):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert (code, out, err.count("\n")) == (2, "", 1) and sentence in err, err
    monkeypatch.setenv("XDG_CONFIG_HOME", "/proc/self")
    assert main(["tune", "cantilever", "--error", "2%"]) == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "other.json"]
