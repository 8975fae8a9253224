"""Short runs from the command line, their summaries and their files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.inputs.option_fields import options_of
from warp_softbody.stage_exports import read_take, validate

PARTS = ("all", "assembly", "solve", "contact", "control", "export")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("run")


@pytest.fixture
def summary(call: Any, folder: Path) -> dict[str, Any]:
    """A run with every file, made once."""
    kept = folder / "summary.json"
    if not kept.exists():
        files = ("--out", folder / "i.usdc", "--picture", folder / "i.png", "--movie")
        answer = call("run", "balance-i", "--seconds", 0.3, "--json", *files, folder / "i.gif")
        assert (answer.code, answer.err) == (0, "")
        kept.write_text(answer.out)
    return dict(json.loads(kept.read_text()))


def test_json_is_one_object_with_every_field(summary: dict[str, Any]) -> None:
    assert (summary["scene"], summary["status"], summary["frames"]) == ("balance-i", "complete", 10)
    assert summary["simulated_seconds"] == pytest.approx(0.3)
    assert summary["wall_seconds"] > 0.0 and summary["setup_seconds"] > 0.0
    assert (summary["tets"], summary["nodes"], summary["segments"]) == (1048, 339, 48)
    assert summary["patches"] == 4
    for part in PARTS:
        spread = summary["step_ms"][part]
        assert 0.0 < spread["median"] <= spread["p95"], part
    assert summary["qps_per_step"]["mean"] >= 1.0
    assert summary["cg_iterations"]["mean"] > 0.0
    assert (summary["controller"], summary["settings"]["push"]) == ("qpcc", 0.5)


def test_stage_reads_back(summary: dict[str, Any], folder: Path) -> None:
    assert summary["stage"] == str(folder / "i.usdc")
    take = read_take(folder / "i.usdc")
    assert len(take) == summary["frames"]
    assert take.times[-1] == pytest.approx(summary["simulated_seconds"])
    assert np.isfinite(take.tet_points).all()
    assert np.ptp(take.tet_points, axis=0).max() > 1e-4
    assert take.metadata["scene"] == "balance-i"
    assert validate(folder / "i.usdc") == []


CHOSEN = {
    "precision": "float32",
    "tolerance": 1e-5,
    "elements": "smoothed",
    "tangent": "conserving",
}
"""What "auto" stands for in this scene."""


def test_every_option_is_told(summary: dict[str, Any], folder: Path) -> None:
    """In the JSON as used, in the stage as asked for; what the motion does not hang on is not."""
    metadata = read_take(folder / "i.usdc").metadata
    for owner in (SimulationOptions, ControlOptions):
        plain = owner(time_step=1 / 60) if owner is SimulationOptions else owner()
        for one in options_of(owner):
            value = getattr(plain, one.name)
            told = CHOSEN.get(one.name, value)
            if one.flag:
                assert summary[one.name] == told, one.name
            stored = one.flag and one.moves and value is not None
            assert (one.name in metadata) == stored, one.name
    assert metadata["planned_cone"] == 8 and metadata["preconditioner"] == "auto"


def test_options_of_both_classes_reach_the_run(call: Any) -> None:
    flags = ("--max-qps", 1, "--planned-cone", 4, "--preconditioner", "two_level", "--no-sleep")
    answer = call("run", "balance-i", *flags, "--seconds", 0.1, "--json")
    summary = json.loads(answer.out)
    told = [summary[name] for name in ("max_qps", "planned_cone", "preconditioner", "sleep")]
    assert told == [1, 4, "two_level", False]
    assert summary["qps_per_step"]["p95"] <= 1.0


def test_picture_and_movie_are_drawn(summary: dict[str, Any], folder: Path) -> None:
    imageio = pytest.importorskip("imageio.v2")
    picture = imageio.imread(folder / "i.png")
    assert picture.std() > 10.0
    frames = imageio.mimread(folder / "i.gif")
    assert len(frames) == summary["frames"]
    assert (frames[0] != frames[-1]).any()
    assert sorted(path.name for path in folder.iterdir()) == [
        "i.gif",
        "i.png",
        "i.usdc",
        "summary.json",
    ]


def test_two_runs_write_the_same_bytes(call: Any, start: Any, tmp_path: Path) -> None:
    arguments = ("run", "balance-i", "--seconds", 0.2, "--quiet", "--out")
    other = start(*arguments, tmp_path / "two.usdc")
    assert call(*arguments, tmp_path / "one.usdc").code == 0
    assert other.communicate() == ("", "")
    assert (tmp_path / "one.usdc").read_bytes() == (tmp_path / "two.usdc").read_bytes()


def test_text_summary_says_that_the_time_step_was_shortened(call: Any) -> None:
    answer = call("run", "topple-i", "--seconds", 0.1, "--time-step", 0.01, "--fps", 30)
    assert (answer.code, answer.err) == (0, "")
    head, *rest = answer.out.splitlines()
    assert head == "topple-i: 0.1 s in 4 frames, complete"
    assert {line.split("  ")[1] for line in rest} >= {"real time", "step", "parts", "body"}
    assert "8.333 ms, shortened from 10 ms to fit 4 steps into a frame" in answer.out


def test_quiet_prints_nothing_and_settings_reach_the_scene(call: Any, tmp_path: Path) -> None:
    for push in (0, 1):
        settings = ("--set", f"push={push}", "--seconds", 0.6, "--fps", 10)
        out = ("--quiet", "--out", tmp_path / f"{push}.usdc")
        assert call("run", "topple-i", *settings, *out).out == ""
    still, pushed = (read_take(tmp_path / f"{push}.usdc") for push in (0, 1))
    assert still.fps == 10.0
    np.testing.assert_array_equal(still.tet_points[5], pushed.tet_points[5])
    assert (pushed.tet_points[6] - still.tet_points[6])[:, 0].max() > 0.01


@pytest.mark.parametrize("method", ["static", "none"])
def test_other_controllers(call: Any, method: str) -> None:
    answer = call("run", "balance-i", "--controller", method, "--seconds", 0.1, "--json")
    summary = json.loads(answer.out)
    assert (answer.code, summary["controller"]) == (0, method)
    assert (summary["qps_per_step"]["mean"] > 0.0) == (method == "static")
    assert summary["stage"] is None


def test_double_precision(call: Any) -> None:
    answer = call("run", "topple-i", "--precision", "float64", "--seconds", 0.1, "--json")
    assert json.loads(answer.out)["precision"] == "float64"


def test_plots_of_a_run(call: Any, tmp_path: Path) -> None:
    answer = call("run", "drop-block", "--seconds", 0.1, "--json", "--plots", tmp_path / "p")
    assert (answer.code, answer.err) == (0, "")
    assert json.loads(answer.out)["plots"] == str(tmp_path / "p")
    assert (tmp_path / "p" / "energy.csv").exists() and (tmp_path / "p" / "momentum.png").exists()
    refused = call("run", "drop-block", "--plots", tmp_path / "p" / "energy.csv")
    assert refused.code == 2 and "is a file" in refused.err
