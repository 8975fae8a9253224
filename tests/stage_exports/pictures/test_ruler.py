"""The measuring rod of a sheet: where it lies, how long it is and when there is none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import imageio.v2 as imageio
import numpy as np
import pytest

from warp_softbody.stage_exports import StageWriter, draw_take
from warp_softbody.stage_exports.pictures.ruler import FloorRuler
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

SQUARE = np.array([[-0.2, -0.1], [0.2, -0.1], [0.2, 0.1], [-0.2, 0.1]])


def rod(length: float, angle: float = 0.0) -> FloorRuler | None:
    """Beside a square that goes so far at an angle to the first axis."""
    along = np.array([np.cos(angle), np.sin(angle)])
    way = np.linspace(0.0, length, 5)[:, None] * along
    points = (way[:, None, :] + SQUARE).reshape(-1, 2)
    return FloorRuler.beside(way, points, np.array([0.3, -1.0]), size=1.0)


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, -2.5])
def test_it_lies_along_the_way_on_the_side_of_the_viewer(angle: float) -> None:
    ruler = rod(1.5, angle)
    assert ruler is not None
    along = np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(ruler.along, along, atol=1e-12)
    assert abs(ruler.side @ along) < 1e-12 and ruler.side @ (0.3, -1.0) > 0.0
    points = (np.linspace(0.0, 1.5, 5)[:, None, None] * along + SQUARE).reshape(-1, 2)
    nearest = ((points - ruler.start) @ ruler.side).max()
    assert nearest < -ruler.half_width


@pytest.mark.parametrize(("length", "band"), [(0.2, 0.05), (0.5, 0.1), (1.5, 0.2), (40.0, 0.2)])
def test_bands_are_round_lengths_and_end_ahead_of_the_body(length: float, band: float) -> None:
    ruler = rod(length)
    assert ruler is not None
    assert ruler.band == pytest.approx(band)
    assert length + 0.2 <= ruler.bands * ruler.band < length + 0.2 + band + 1e-9
    words = ruler.ticks(2)
    places = np.array([place for _, place in words])
    told = np.array([float(word) for word, _ in words])
    np.testing.assert_allclose((places - ruler.start) @ ruler.along, told, atol=1e-9)


def test_a_body_that_stays_has_none() -> None:
    assert rod(0.1) is None


def test_bands_take_turns_and_nothing_beside_them_is_covered() -> None:
    ruler = rod(1.5)
    assert ruler is not None
    middles = (np.arange(ruler.bands) + 0.5) * ruler.band
    fine = np.full((len(middles), 2), 1e-3)
    cover, bright = ruler.shade(ruler.start + middles[:, None] * ruler.along, fine)
    np.testing.assert_allclose(cover, 1.0)
    assert (bright[::2] < 0.3).all() and (bright[1::2] > 2.0).all()
    beside = ruler.start + middles[:, None] * ruler.along + 1.5 * ruler.half_width * ruler.side
    ends = ruler.start + np.outer([-0.02, ruler.bands * ruler.band + 0.02], ruler.along)
    places = np.concatenate([beside, ends])
    assert not ruler.shade(places, np.full((len(places), 2), 1e-3))[0].any()


def test_seen_from_afar_bands_become_their_mean() -> None:
    ruler = rod(1.5)
    assert ruler is not None
    edge = ruler.start + ruler.band * ruler.along
    _, bright = ruler.shade(edge[None], np.full((1, 2), 1e-3))
    _, dark = ruler.shade((edge - 0.5 * ruler.band * ruler.along)[None], np.full((1, 2), 1e-3))
    _, light = ruler.shade((edge + 0.5 * ruler.band * ruler.along)[None], np.full((1, 2), 1e-3))
    assert bright[0] == pytest.approx((dark[0] + light[0]) / 2.0, rel=1e-6)


def test_a_sheet_shows_it_where_the_body_goes(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    """Its bright bands are in no picture without it."""
    first: Frame = next(iter(make_frames(scene)))
    rest = np.asarray(scene.character.mesh.points)
    whites = []
    for speed in (0.0, 0.4):
        stage = tmp_path / f"{speed}.usdc"
        with StageWriter(stage, scene) as writer:
            for index in range(3):
                way = np.array([speed * index, 0.0, 0.0])
                values = {name: getattr(first, name) for name in ("activations", "contacts")}
                writer.write(
                    Frame(
                        index=index,
                        time=index / 30.0,
                        positions=rest + way,
                        velocities=np.zeros_like(rest),
                        fiber_points=np.asarray(first.fiber_points) + way,
                        **values,
                    )
                )
        for ruler in (False, True):
            path = tmp_path / f"{speed}-{ruler}.png"
            image = imageio.imread(draw_take(path, stage, count=3, size=(120, 90), ruler=ruler))
            whites.append(int((np.asarray(image)[:90, :120].min(axis=2) > 200).sum()))
    assert whites[:3] == [0, 0, 0] and whites[3] > 10
