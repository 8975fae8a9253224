"""One HTML file that plays a take: whole, small, closed to everything else, and never half."""

from __future__ import annotations

import base64
import hashlib
import re
import zlib
from pathlib import Path

import numpy as np
import pytest

import warp_softbody as wsb
from tests.live.messages import read_take_page
from warp_softbody.errors import InputError, OutputError
from warp_softbody.live import HtmlTake


def frames_of(name: str, count: int) -> tuple[wsb.Scene, list[wsb.Frame]]:
    plan = wsb.scenes.make(name)
    simulation = wsb.Simulation(plan.scene, time_step=plan.time_step)
    return plan.scene, list(simulation.run(max(0.01, (count - 1) / 30.0)))


def written(path: Path, name: str = "balance-i", count: int = 6) -> tuple[str, list[wsb.Frame]]:
    scene, frames = frames_of(name, count)
    with HtmlTake(path, scene, name=name) as take:
        for frame in frames:
            take.write(frame)
    return path.read_text(encoding="utf-8"), frames


@pytest.mark.parametrize("name", ["balance-i", "stack"])
def test_the_page_holds_every_frame(tmp_path: Path, name: str) -> None:
    page, frames = written(tmp_path / "take.html", name)
    outline, updates = read_take_page(page)
    assert outline["name"] == name and len(updates) == len(frames)
    assert [told.time for told in updates] == [frame.time for frame in frames]
    surface = np.unique(wsb.scenes.make(name).scene.whole.mesh.surface)
    for told, frame in zip(updates, frames, strict=True):
        wanted = np.concatenate([frame.positions[surface], frame.fiber_points])
        np.testing.assert_allclose(told.places, wanted, atol=0.501 * told.scale + 1e-6)
    assert np.abs(updates[0].places - updates[-1].places).max() > 1e-4


def test_nothing_but_the_player_may_run_and_nothing_be_asked_for(tmp_path: Path) -> None:
    page, _ = written(tmp_path / "take.html")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)
    player = re.search(r'id="player">([^<]*)<', page)
    assert policy is not None and player is not None
    assert policy.group(1).startswith("default-src 'none'; script-src 'sha256-")
    starter = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    style = re.findall(r"<style>(.*?)</style>", page, re.DOTALL)
    code = zlib.decompress(base64.b64decode(player.group(1))).decode()
    assert len(starter) == len(style) == 1
    for text in (*starter, *style, code):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy.group(1)
    assert not re.search(r"(src|href)=", page.split("<body>")[0].split("</style>")[1])
    assert "Copyright" in page and "three.js authors" in page


def test_ninety_frames_are_small(tmp_path: Path) -> None:
    _, frames = written(tmp_path / "take.html", count=91)
    assert len(frames) == 91
    assert (tmp_path / "take.html").stat().st_size < 750_000


def test_an_error_leaves_the_frames_so_far(tmp_path: Path) -> None:
    scene, frames = frames_of("balance-i", 3)
    path = tmp_path / "take.html"
    with pytest.raises(RuntimeError), HtmlTake(path, scene) as take:
        for frame in frames[:2]:
            take.write(frame)
        raise RuntimeError
    assert len(read_take_page(path.read_text())[1]) == 2
    with pytest.raises(OutputError, match="is closed"):
        take.write(frames[2])
    take.close()


def test_without_a_frame_nothing_is_left(tmp_path: Path) -> None:
    scene, _ = frames_of("balance-i", 1)
    older = tmp_path / "take.html"
    older.write_text("older")
    with HtmlTake(older, scene):
        pass
    assert older.read_text() == "older" and list(tmp_path.iterdir()) == [older]


def test_wrong_values_are_refused(tmp_path: Path) -> None:
    scene, frames = frames_of("balance-i", 1)
    other, _ = frames_of("stack", 1)
    with pytest.raises(OutputError, match=r"the file name must end in one of \.html"):
        HtmlTake(tmp_path / "take.htm", scene)
    with pytest.raises(InputError, match="fps of an HtmlTake"):
        HtmlTake(tmp_path / "take.html", scene, fps=0.0)
    with pytest.raises(InputError, match="positions must have"):
        HtmlTake(tmp_path / "take.html", other).write(frames[0])
    assert not list(tmp_path.iterdir())


def test_a_name_cannot_become_markup(tmp_path: Path) -> None:
    scene, frames = frames_of("balance-i", 1)
    path = tmp_path / "take.html"
    with HtmlTake(path, scene, name="</title><script>&") as take:
        take.write(frames[0])
    page = path.read_text()
    assert "<title>&lt;/title&gt;&lt;script&gt;&amp;</title>" in page
    assert read_take_page(page)[0]["name"] == "</title><script>&"
    with pytest.raises(InputError, match="name of an HtmlTake"):
        HtmlTake(path, scene, name="")
