"""Another reader sees the same skin, and importing the package loads nothing heavy."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from warp_softbody import stage_exports
from warp_softbody.stage_exports.layout import Layout
from warp_softbody.world.scene import Scene


def test_tinyusdz_reads_the_same_skin(scene: Scene, make_frames: Any, write_take: Any) -> None:
    tinyusdz = pytest.importorskip("tinyusdz")
    skin = tinyusdz.load(str(write_take())).get_prim_at_path("/World/block/Skin")
    samples = skin.get_attribute_timesamples("points")
    nodes = Layout.of(scene.character).skin_nodes
    frames = list(make_frames(scene))
    assert [code for code, _ in samples] == [float(frame.index) for frame in frames]
    for (_, points), frame in zip(samples, frames, strict=True):
        np.testing.assert_allclose(np.asarray(points), frame.positions[nodes], atol=1e-7)


def test_importing_loads_neither_usd_nor_the_renderer() -> None:
    code = (
        "import sys, warp_softbody.stage_exports\n"
        "print([name for name in ('pxr', 'embreex', 'imageio') if name in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    )
    assert done.stdout.strip() == "[]"


def test_public_names_are_found_and_others_are_not() -> None:
    for name in stage_exports.__all__:
        assert callable(getattr(stage_exports, name))
    assert set(stage_exports.__all__) <= set(dir(stage_exports))
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = stage_exports.no_such_name
