"""One frame of a stage as a picture: which, from where, and what of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from warp_softbody.cli import main
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import draw_frame

SMALL = (48, 36)


def drawn(path: Path, stage: Path, **chosen: Any) -> Any:
    image = Image.open(draw_frame(path, stage, **{"size": SMALL, **chosen}))
    return np.asarray(image).astype(int)


def test_frames_times_cameras_and_layers_make_a_difference(write_take: Any, tmp_path: Path) -> None:
    stage, path = write_take(), tmp_path / "a.png"
    last = drawn(path, stage)
    assert last.shape == (36, 48, 3)
    np.testing.assert_array_equal(last, drawn(path, stage, frame=-1))
    np.testing.assert_array_equal(last, drawn(path, stage, time=5.0 / 30.0))
    others = [
        drawn(path, stage, frame=0),
        drawn(path, stage, camera=(1.0, -1.0, 0.5)),
        drawn(path, stage, layers=("skin", "ground")),
        drawn(path, stage, layers=("muscles", "ground")),
        drawn(path, stage, layers=("skin",)),
        drawn(path, stage, caption=True),
    ]
    for image in others:
        assert np.abs(image - last).max() > 20
    assert drawn(path, stage, size=(64, 32)).shape == (32, 64, 3)


def test_a_transparent_picture_holds_the_body_alone(write_take: Any, tmp_path: Path) -> None:
    image = drawn(tmp_path / "a.png", write_take(), transparent=True, layers=("skin",))
    alpha = image[..., 3]
    assert alpha[0, 0] == alpha[-1, -1] == 0 and alpha.max() == 255
    red = image[alpha == 255]
    assert (red[:, 0] > red[:, 2]).all()


@pytest.mark.parametrize(
    ("chosen", "sentence"),
    [
        ({"frame": 6}, "from 0 to 5"),
        ({"frame": 1, "time": 0.1}, "not both"),
        ({"layers": ("skin", "hair")}, "a layer of draw_frame"),
        ({"layers": "skin"}, "a sequence of names"),
        ({"layers": ("ground",)}, '"skin" or "muscles"'),
        ({"camera": "above"}, "camera of draw_frame"),
    ],
)
def test_what_cannot_be_drawn_is_one_sentence(
    write_take: Any, tmp_path: Path, chosen: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        draw_frame(tmp_path / "a.png", write_take(), **chosen)
    assert not (tmp_path / "a.png").exists()


def test_the_command_draws_frames_and_sheets(
    write_take: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stage = str(write_take())
    one, sheet = tmp_path / "one.png", tmp_path / "sheet.png"
    small = ("--size", "48x36")
    assert main(["picture", stage, "-o", str(one), "--frame", "2", "--json", *small]) == 0
    assert json.loads(capsys.readouterr().out) == {"stage": stage, "file": str(one)}
    assert main(["picture", stage, "-o", str(sheet), "--sheet", "2", *small]) == 0
    assert Image.open(one).size == (48, 36) and Image.open(sheet).size == (100, 36)
    assert main(["picture", stage, "-o", str(sheet), "--sheet", "2", "--time", "0"]) == 2
    assert "--sheet goes with" in capsys.readouterr().err
