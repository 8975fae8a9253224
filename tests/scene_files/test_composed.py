"""Sequences and combinations in scene files."""

from __future__ import annotations

from pathlib import Path

import pytest

from warp_softbody import Plane, Scene, characters, scene_files
from warp_softbody.controllers import Balance, Combined, Gesture, Motion, Sequence, Sway, Walk
from warp_softbody.errors import InputError
from warp_softbody.scene_files.motions import table_of_controller
from warp_softbody.scenes.plan import ScenePlan

LETTER = '[character]\nshape = "letter_i"\ncoarse = 1\n'
SEQUENCE = LETTER + '[controller]\nkind = "sequence"\n'
BALANCE = '[[controller.motions]]\nkind = "balance"\n'


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (SEQUENCE, "4: controller: motions of Sequence must hold a motion"),
        (SEQUENCE + "motion = 1\n", "6: controller.motion: .* did you mean 'motions'"),
        (SEQUENCE + "rounds = 0\n" + BALANCE + "seconds = 1\n", "6: controller.rounds: "),
        (SEQUENCE + BALANCE * 2, r"7: controller.motions\[0\].kind: never ends, but another"),
        (
            SEQUENCE + BALANCE + "seconds = -1\n",
            r"8: controller.motions\[0\].seconds: Motion.seconds must be",
        ),
        (
            SEQUENCE + BALANCE + "distanc = 1\n",
            r"8: controller.motions\[0\].distanc: .* did you mean 'distance'",
        ),
        (
            SEQUENCE + BALANCE + 'seconds = 1\n[[controller.motions]]\nkind = "crawl"\n',
            r"10: controller.motions\[1\].kind: .* no region 'corner_0'",
        ),
        (
            SEQUENCE + '[[controller.motions]]\nkind = "combined"\n'
            '[[controller.motions.together]]\nkind = "balance"\n'
            '[[controller.motions.together]]\nkind = "gesture"\nregion = "tail"\n',
            r"11: controller.motions\[0\].together\[1\].kind: .* no region 'tail'",
        ),
        (
            LETTER + '[controller]\nkind = "combined"\n[[controller.together]]\nkind = "balance"\n'
            "weight = -1\n",
            r"8: controller.together\[0\].weight: weight must be",
        ),
        (LETTER + '[controller]\nkind = "combined"\n', "4: controller: .* a controller at least"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(text: str, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=sentence) as raised:
        scene_files.read(file)
    assert str(raised.value).startswith(f"{file}:")


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    letter = characters.letter_i(coarse=1)
    waving = Combined(
        [Balance.for_(letter), Gesture(region="head", path=Sway(amplitude=0.02))],
        weights=(1.0, 0.5),
    )
    sequence = Sequence(
        [
            Motion(controller=waving, seconds=2.0, name="wave"),
            Motion(controller=Walk.for_(letter, heading=0.5), distance=0.2, seconds=9.0),
            Balance(),
        ],
        rounds=1,
        fade=0.25,
    )
    plan = ScenePlan(
        name="composed",
        description="of several motions",
        scene=Scene(character=letter, ground=Plane()),
        controller=sequence,
        seconds=5.0,
        time_step=1 / 60,
        settings={},
    )
    scene_files.write(tmp_path / "own.toml", plan)
    again = scene_files.read(tmp_path / "own.toml").plan.controller
    assert isinstance(again, Sequence)
    assert table_of_controller(again) == table_of_controller(sequence)
    assert [motion.title for motion in again.motions] == ["wave", "walk", "balance"]
    assert again.motions[1].distance == 0.2


def test_functions_cannot_be_written() -> None:
    ends = Motion(controller=Balance(), until=lambda view: True)
    with pytest.raises(InputError, match="ends by a function, which cannot be written"):
        table_of_controller(Sequence([ends, Balance()]))
    with pytest.raises(InputError, match="a controller of the class function cannot be written"):
        table_of_controller(Combined([Balance(), lambda view: ()]))
