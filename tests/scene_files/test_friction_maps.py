"""Friction by place in scene files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from warp_softbody import FrictionMap, HeightField, Plane, Scene, scene_files, scenes
from warp_softbody.errors import InputError
from warp_softbody.scenes.plan import ScenePlan
from warp_softbody.world.ground import Ground

SMALL = '[character]\nshape = "box"\nname = "cube"\nsize = [0.1, 0.1, 0.1]\ncells = [1, 1, 1]\n'
FACTORS = np.array([[1.0, 0.5], [0.25, 2.0]])


def read(folder: Path, text: str) -> Ground | None:
    file = folder / "scene.toml"
    file.write_text(text + SMALL)
    return scene_files.read(file).plan.scene.ground


@pytest.mark.parametrize("source", ["factors = [[1, 0.5], [0.25, 2]]", 'file = "f.npy"'])
def test_factors_stand_in_the_file_or_beside_it(source: str, tmp_path: Path) -> None:
    np.save(tmp_path / "f.npy", FACTORS)
    text = f'[ground]\nkind = "plane"\n[ground.friction_map]\nspacing = [0.5, 2.0]\n{source}\n'
    assert read(tmp_path, text) == Plane(
        friction_map=FrictionMap(factors=FACTORS, spacing=(0.5, 2.0))
    )


@pytest.mark.parametrize(
    ("lines", "sentence"),
    [
        ("factors = [[-1]]", "4: ground.friction_map.factors: FrictionMap.factors must not be neg"),
        ("width = 1", "4: ground.friction_map.width: there is no key 'width'"),
        ("spacing = [1, 1]", "3: ground.friction_map: the key 'factors' is missing"),
        ('file = "g.npy"', "4: ground.friction_map.file: file .*g.npy: there is no such file"),
        ('factors = [[1]]\nfile = "g.npy"', "5: ground.friction_map.file: goes without 'factors'"),
        ('file = "n.txt"', "4: ground.friction_map.file: file .*n.txt: .*factors must not be neg"),
        ('spacing = [0, 1]\nfile = "f.txt"', "4: ground.friction_map.spacing: .* must be positive"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(lines: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "n.txt").write_text("1 -1\n")
    (tmp_path / "f.txt").write_text("1 0\n")
    with pytest.raises(InputError, match=sentence):
        read(tmp_path, f'[ground]\nkind = "plane"\n[ground.friction_map]\n{lines}\n')


@pytest.mark.parametrize("size", [2, 20])
def test_what_is_written_is_read_again(size: int, tmp_path: Path) -> None:
    factors = np.random.default_rng(1).uniform(0.0, 2.0, (size, size))
    placed = FrictionMap(factors=factors, spacing=(0.1, 0.3), origin=(-1.0, 0.1))
    for ground in (
        Plane(friction=0.4, friction_map=placed),
        HeightField(heights=np.eye(3), friction_map=placed),
    ):
        plan = scenes.make("drop-block")
        scene = Scene(character=plan.scene.character, ground=ground)
        content = ScenePlan(
            **{name: getattr(plan, name) for name in ("name", "description", "controller")},
            **{name: getattr(plan, name) for name in ("seconds", "time_step", "settings")},
            scene=scene,
        )
        scene_files.write(tmp_path / "again.toml", content)
        assert scene_files.read(tmp_path / "again.toml").plan.scene.ground == ground
