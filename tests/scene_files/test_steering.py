"""Steering in scene files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warp_softbody import Plane, Scene, characters, scene_files
from warp_softbody.controllers import DIAGONAL_PAIRS, Steering, Trail, Walk
from warp_softbody.controllers.arguments import arguments_of
from warp_softbody.errors import InputError
from warp_softbody.inputs.records import same
from warp_softbody.scene_files.motions import table_of_controller
from warp_softbody.scenes.plan import ScenePlan

WALK = """[character]
shape = "letter_x"
coarse = 1
[controller]
kind = "walk"
gait = [[0, 3], [1, 2]]
"""


def read(text: str, folder: Path) -> ScenePlan:
    file = folder / "own.toml"
    file.write_text(text)
    return scene_files.read(file).plan


@pytest.mark.parametrize(
    ("text", "steering"),
    [
        ("steering = { turning = 0.2 }", Steering(turning=0.2)),
        (
            "[[controller.steering]]\nforward = 0.2\n"
            "[[controller.steering]]\nstart = 3\naside = 0.1",
            (Steering(forward=0.2), Steering(start=3.0, aside=0.1)),
        ),
        (
            "steering = { points = [[0, 0], [1, 0], [1, 1]], forward = 0.2 }",
            Trail(points=np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]), forward=0.2),
        ),
    ],
)
def test_what_steers_is_read_and_written(text: str, steering: object, tmp_path: Path) -> None:
    plan = read(WALK + text + "\n", tmp_path)
    assert same((arguments_of(plan.controller) or {})["steering"], steering)
    own = Walk(gait=DIAGONAL_PAIRS, steering=steering)  # type: ignore[arg-type]
    scene = Scene(character=characters.letter_x(), ground=Plane())
    written = ScenePlan(
        name="own",
        description="a walk",
        scene=scene,
        controller=own,
        seconds=1.0,
        time_step=0.01,
        settings={},
    )
    scene_files.write(tmp_path / "written.toml", written)
    again = scene_files.read(tmp_path / "written.toml").plan.controller
    assert same((arguments_of(again) or {})["steering"], steering)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("steering = { turn = 0.2 }", "7: controller.steering.turn: .* did you mean 'turning'"),
        ("steering = { turning = nan }", "7: controller.steering.turning: .*finite"),
        ("steering = { points = [[0, 0]] }", "7: controller.steering.points: .*two points or more"),
        ('steering = "left"', "7: controller.steering"),
        (
            "[[controller.steering]]\nstart = 1\n[[controller.steering]]\nstart = 1",
            r"steering of Walk\[1\].start must be after",
        ),
    ],
)
def test_what_is_wrong_is_told_with_its_line(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        read(WALK + text + "\n", tmp_path)


def test_a_function_cannot_be_written() -> None:
    walk = Walk(gait=DIAGONAL_PAIRS, steering=lambda view: Steering())
    with pytest.raises(InputError, match="steered by a function cannot be written"):
        table_of_controller(walk)
