"""Every shipped scene, written as a file and read back, is the same to the last bit."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from warp_softbody import scene_files, scenes
from warp_softbody.controllers.arguments import arguments_of
from warp_softbody.errors import InputError
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes.plan import ScenePlan


def reread(plan: ScenePlan, folder: Path) -> scene_files.SceneFile:
    scene_files.write(folder / "scene.toml", plan)
    return scene_files.read(folder / "scene.toml")


@pytest.mark.parametrize("name", scenes.names())
def test_all_values_come_back(name: str, tmp_path: Path) -> None:
    plan = scenes.make(name)
    found = reread(plan, tmp_path).plan
    assert found.scene == plan.scene
    assert type(found.controller) is type(plan.controller)
    if plan.controller is not None:
        assert arguments_of(found.controller) == arguments_of(plan.controller)
    for attribute in ("name", "description", "seconds", "time_step"):
        assert getattr(found, attribute) == getattr(plan, attribute)


@pytest.mark.parametrize("name", ["balance-i", "walk-x", "roll-o", "stack", "stairs"])
def test_the_run_is_the_same_to_the_last_bit(name: str, tmp_path: Path) -> None:
    plan = scenes.make(name)
    file = reread(plan, tmp_path)
    one = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    other = file.simulation()
    for a, b in islice(zip(one.run(0.2), other.run(0.2), strict=True), 7):
        for array in ("positions", "velocities", "activations"):
            np.testing.assert_array_equal(getattr(a, array), getattr(b, array))


def test_settings_are_written_too(tmp_path: Path) -> None:
    plan = scenes.make("balance-i", {"coarse": 1, "push": 0.2})
    assert reread(plan, tmp_path).plan.scene == plan.scene
    text = (tmp_path / "scene.toml").read_text()
    assert 'shape = "letter_i"\ncoarse = 1\n' in text


def test_the_same_scene_gives_the_same_bytes(tmp_path: Path) -> None:
    plan = scenes.make("rough-ground")
    contents = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        scene_files.write(tmp_path / folder / "s.toml", plan)
        found = sorted(path for path in (tmp_path / folder).rglob("*") if path.is_file())
        contents.append([path.read_bytes() for path in found])
    assert contents[0] == contents[1] and len(contents[0]) == 3


def test_a_strangers_controller_is_refused(tmp_path: Path) -> None:
    class Own:
        def goals(self, view: object) -> None:
            return None

    plan = scenes.make("topple-i")
    own = ScenePlan(**{**vars(plan), "controller": Own()})
    with pytest.raises(InputError, match="controller of the class Own cannot be written"):
        scene_files.write(tmp_path / "own.toml", own)
    assert not list(tmp_path.iterdir())
