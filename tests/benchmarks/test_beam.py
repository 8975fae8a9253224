"""The beam benchmark runs and says what it is meant to; its times are not tested."""

from __future__ import annotations

import json

import pytest

from benchmarks.beam import main


def test_beam_prints_its_sag_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    main(["--tets", "810", "--steps", "3", "--json"])
    (result,) = json.loads(capsys.readouterr().out)
    assert result["tets"] == 810
    assert result["sag"] == pytest.approx(0.21750, rel=0.005)
    assert result["step_ms"] > 0.0


def test_unknown_size_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--tets", "811"])
    assert "811" in capsys.readouterr().err
