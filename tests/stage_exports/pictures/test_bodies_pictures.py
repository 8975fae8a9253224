"""Pictures and movies of several bodies show them all, each in its colour."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.stage_exports.crowd import FRAMES, NAMES, frame_at
from tests.support.bodies import box
from warp_softbody.body.character import Character
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import Movie, draw_picture, draw_take, read_take, take_bounds
from warp_softbody.world.frame import ContactSample
from warp_softbody.world.joined_bodies import Body
from warp_softbody.world.scene import Scene

imageio = pytest.importorskip("imageio.v2")
pytest.importorskip("embreex")

SMALL = (160, 90)
Image = npt.NDArray[np.int16]


def read(path: Path) -> Image:
    return np.asarray(imageio.imread(path), dtype=np.int16)


def shares(image: Image) -> list[float]:
    """Parts of the picture in the colours of tower, bar and cube: mostly red, green, blue."""
    red, green, blue = (image[..., channel] for channel in range(3))
    masks = (
        (red > green + 40) & (red > blue + 40),
        (green > red + 25) & (green > blue + 25),
        (blue > red + 40) & (blue > green + 40),
    )
    return [float(mask.mean()) for mask in masks]


def test_a_picture_shows_every_body_in_its_colour(crowd: Scene, tmp_path: Path) -> None:
    image = read(draw_picture(tmp_path / "all.png", crowd, frame_at(crowd, 0), size=SMALL))
    assert min(shares(image)) > 0.01
    outside = np.concatenate([image[[0, -1]].reshape(-1, 3), image[:, [0, -1]].reshape(-1, 3)])
    assert max(shares(outside[None])) == 0.0
    alone = replace(crowd, others=())
    single = read(draw_picture(tmp_path / "one.png", alone, frame_at(alone, 0), size=SMALL))
    assert shares(single)[0] > 0.01 and shares(single)[1:] == [0.0, 0.0]


def test_a_stage_is_drawn_as_the_scene_was(crowd: Scene, write_crowd: Any, tmp_path: Path) -> None:
    path = write_crowd()
    takes = [read_take(path, name) for name in NAMES]
    whole = read(draw_take(tmp_path / "all.png", path, count=2, size=SMALL))
    again = read(draw_take(tmp_path / "again.png", takes, count=2, size=SMALL))
    assert (whole == again).all()
    tiles = [whole[:, :160], whole[:, 164:]]
    assert all(min(shares(tile)) > 0.01 for tile in tiles)
    assert np.abs(tiles[0] - tiles[1]).max() > 40
    single = read(draw_take(tmp_path / "bar.png", takes[1], count=1, size=SMALL))
    assert shares(single)[1] > 0.01 and shares(single)[0] == shares(single)[2] == 0.0
    low, high = take_bounds(*takes)
    everything = np.concatenate([frame_at(crowd, i).positions for i in range(FRAMES)])
    np.testing.assert_array_equal(low, np.float32(everything.min(axis=0)))
    np.testing.assert_array_equal(high, np.float32(everything.max(axis=0)))


def test_a_movie_shows_every_body(crowd: Scene, tmp_path: Path) -> None:
    with Movie(tmp_path / "all.gif", crowd, size=SMALL) as movie:
        movie.write(frame_at(crowd, 0))
    (image,) = imageio.mimread(tmp_path / "all.gif")
    assert min(shares(np.asarray(image, dtype=np.int16)[..., :3])) > 0.01


def test_fibres_show_through_their_own_body_only(crowd: Scene, tmp_path: Path) -> None:
    """With a wall in front of the bar its activations change nothing in the picture."""
    bar = crowd.others[0].character
    wall = Character(name="wall", mesh=box((4, 1, 4), (1.4, 0.05, 1.0), (0.0, -0.1, 0.0)))

    def change(*bodies: Character) -> int:
        scene = Scene(character=bodies[0], others=tuple(Body(character=b) for b in bodies[1:]))
        frame = frame_at(replace(crowd, others=()), 0)
        frame = replace(
            frame,
            positions=scene.whole.mesh.points,
            fiber_points=np.concatenate([fiber.vertices for fiber in bar.fibers]),
            contacts=ContactSample(),
        )
        images = [
            read(
                draw_picture(
                    tmp_path / "tense.png",
                    scene,
                    replace(frame, activations=np.full(bar.segment_count, activation)),
                    size=SMALL,
                )
            )
            for activation in (1.0, 0.5)
        ]
        return int(np.abs(images[0] - images[1]).max())

    assert change(bar) > 40
    assert change(bar, wall) == 0


def test_takes_of_different_frames_are_refused(write_crowd: Any, tmp_path: Path) -> None:
    first, second = (read_take(write_crowd(), name) for name in NAMES[:2])
    late = replace(second, times=second.times + 1.0)
    for takes in ([first, late], []):
        with pytest.raises(InputError, match="takes of the same frames"):
            draw_take(tmp_path / "no.png", takes)
    assert not (tmp_path / "no.png").exists()
