"""Every example runs, and does what it says."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from warp_softbody.stage_exports import read_take

ROOT = Path(__file__).parents[2]


def example(name: str) -> ModuleType:
    """An example as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "examples" / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_balance(tmp_path: Path) -> None:
    summary = example("balance").main(tmp_path / "balance.usdc", seconds=0.2)
    assert (summary.status, summary.frames) == ("complete", 7)
    assert len(read_take(tmp_path / "balance.usdc")) == 7


def test_readme_script_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (script,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    exec(script.replace("seconds=6", "seconds=0.1"), {})
    assert "scene: 0.1 s in 4 frames, complete" in capsys.readouterr().out
    assert len(read_take(tmp_path / "balance.usdc")) == 4


def test_own_controller_sways() -> None:
    path = example("own_controller").main(seconds=1.2)
    assert path[:24].max() > 0.01
    assert path[-1] < 0.0


def test_own_loop_falls_and_lands() -> None:
    module = example("own_loop")
    step = 0.005
    heights = module.main(seconds=0.4, time_step=step)
    # free fall of the implicit step: v_k = k g dt, so x_k = g dt^2 k (k + 1) / 2
    count = np.arange(1, 21)
    fallen = 9.81 * step**2 * count * (count + 1) / 2.0
    np.testing.assert_allclose(heights[:20], module.FALL - fallen, atol=1e-5)
    assert heights.min() > -1e-3
    assert abs(heights[-1]) < 1e-3


def test_a_starfish_learns() -> None:
    pytest.importorskip("cmaes")
    ways = example("learn_to_crawl").main(generations=2, seconds=0.5)
    assert len(ways) == 2
    assert np.isfinite(ways).all()
