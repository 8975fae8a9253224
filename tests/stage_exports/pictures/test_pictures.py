"""Pictures are drawn without a display, show the body, and change when it moves."""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from warp_softbody.errors import InputError, MissingExtraError, OutputError
from warp_softbody.stage_exports import Movie, StageWriter, draw_picture, draw_take
from warp_softbody.world.frame import ContactSample, Frame
from warp_softbody.world.scene import Scene

imageio = pytest.importorskip("imageio.v2")
pytest.importorskip("embreex")

SMALL = (120, 90)


def read(path: Path) -> npt.NDArray[np.int16]:
    return np.asarray(imageio.imread(path), dtype=np.int16)


def reddish(image: npt.NDArray[np.int16]) -> npt.NDArray[np.bool_]:
    """The block is warm red, all else is grey or blue."""
    return np.asarray(image[..., 0] > image[..., 2] + 40)


def test_a_picture_shows_the_body_and_its_shadow(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    frame = next(make_frames(scene))
    path = draw_picture(tmp_path / "still.png", scene, frame, size=SMALL)
    image = read(path)
    assert image.shape == (90, 120, 3)
    body = reddish(image)
    assert 0.05 < body.mean() < 0.5
    assert body[45, 60] and not body[0].any() and not body[-1].any()
    floating = replace(frame, positions=frame.positions + np.array([0.0, 0.0, 5.0]))
    bare = read(draw_picture(tmp_path / "bare.png", scene, floating, size=SMALL))
    assert image[~body].min() < bare[~reddish(bare)].min() - 15


def test_pictures_repeat_and_follow_activation(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    frame = next(make_frames(scene))
    tense = replace(frame, activations=frame.activations * 0.5)
    first, again, other = (
        read(draw_picture(tmp_path / f"{index}.png", scene, shown, size=SMALL))
        for index, shown in enumerate((frame, frame, tense))
    )
    assert (first == again).all()
    assert np.abs(first - other).max() > 40


def test_a_body_without_muscles_or_ground_is_drawn(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    bare = Scene(character=replace(scene.character, muscles=()))
    path = draw_picture(tmp_path / "bare.png", bare, next(make_frames(bare)), size=SMALL)
    assert reddish(read(path)).any()


@pytest.mark.parametrize("extension", [".gif", ".mp4"])
def test_movie_frames_differ(
    scene: Scene, make_frames: Any, tmp_path: Path, extension: str
) -> None:
    if extension == ".mp4":
        pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / f"sway{extension}"
    with Movie(path, scene, fps=10, size=SMALL) as movie:
        for frame in make_frames(scene, 4, fps=5.0):
            movie.write(frame)
    images = [np.asarray(image, dtype=np.int16)[..., :3] for image in imageio.mimread(path)]
    assert len(images) == 4 and images[0].shape == (90, 120, 3)
    for first, second in pairwise(images):
        assert (np.abs(first - second).max(axis=2) > 30).mean() > 0.005
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_an_interrupted_movie_keeps_its_frames(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = tmp_path / "cut.gif"
    with pytest.raises(KeyboardInterrupt), Movie(path, scene, size=SMALL) as movie:
        movie.write(next(make_frames(scene)))
        raise KeyboardInterrupt
    assert len(imageio.mimread(path)) == 1
    with Movie(tmp_path / "none.gif", scene, size=SMALL):
        pass
    assert not (tmp_path / "none.gif").exists()


def test_a_take_becomes_a_sheet_of_different_frames(write_take: Any, tmp_path: Path) -> None:
    path = draw_take(tmp_path / "sheet.png", write_take(), count=5, columns=3, size=SMALL)
    sheet = read(path)
    assert sheet.shape == (2 * 90 + 4, 3 * 120 + 2 * 4, 3)
    tiles = [sheet[:90, left : left + 120] for left in (0, 124, 248)]
    assert all(reddish(tile).any() for tile in tiles)
    assert all(np.abs(tile - tiles[0]).max() > 30 for tile in tiles[1:])


def test_frames_of_a_sheet_show_the_body_as_large_as_alone(scene: Scene, tmp_path: Path) -> None:
    """A body that has gone far is small where all frames share a camera, and large otherwise."""
    stage = tmp_path / "far.usdc"
    rest = scene.character.mesh.points
    with StageWriter(stage, scene) as writer:
        for index in range(3):
            way = np.array([3.0 * index, 0.0, 0.0])
            away = rest + way
            fibers = np.concatenate([f.vertices for f in scene.character.fibers])
            writer.write(
                Frame(
                    index=index,
                    time=index / 30.0,
                    positions=away,
                    velocities=np.zeros_like(away),
                    activations=np.ones(scene.character.segment_count),
                    fiber_points=fibers + way,
                    contacts=ContactSample(),
                )
            )
    how: dict[str, Any] = {"count": 3, "columns": 3, "size": SMALL}
    near, far = (
        read(draw_take(tmp_path / f"{follow}.png", stage, follow=follow, captions=False, **how))
        for follow in (True, False)
    )
    tiles = [near[:, left : left + 120] for left in (0, 124, 248)]
    counts = [int(reddish(tile).sum()) for tile in tiles]
    assert min(counts) > 4 * int(reddish(far).sum()) / 3
    assert max(counts) - min(counts) < 0.1 * max(counts)
    told = read(draw_take(tmp_path / "told.png", stage, **how))
    changed = np.abs(told - near).max(axis=2) > 30
    # words stand in the uppermost sixth alone
    assert changed[:15].any() and not changed[15:].any()


def test_refusals(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    frame = next(make_frames(scene))
    with pytest.raises(OutputError, match="must end in one of"):
        draw_picture(tmp_path / "still.jpg", scene, frame)
    with pytest.raises(InputError, match="picture size"):
        draw_picture(tmp_path / "still.png", scene, frame, size=(0, 90))
    with pytest.raises(InputError, match="even width"):
        Movie(tmp_path / "odd.mp4", scene, size=(121, 90))
    assert list(tmp_path.iterdir()) == []


def test_a_missing_extra_is_named(
    scene: Scene, make_frames: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "embreex", None)
    with pytest.raises(MissingExtraError, match=r"warp-softbody\[view\]"):
        draw_picture(tmp_path / "still.png", scene, next(make_frames(scene)), size=SMALL)
    assert list(tmp_path.iterdir()) == []
