"""The camera of stages and movies keeps the bodies in the picture, or stands where it is told."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.run.simulation import Simulation
from warp_softbody.stage_exports import StageWriter
from warp_softbody.stage_exports.camera import Camera
from warp_softbody.stage_exports.camera_paths import camera_path
from warp_softbody.world.scene import Scene

ASPECT = 4.0 / 3.0
BODY = np.random.default_rng(1).random((60, 3)) * (0.4, 0.3, 1.0)


def seen(camera: Camera, points: FloatArray) -> tuple[float, float]:
    """How far out a point is, 1 at the picture's rim, and the points' share of its height."""
    right, up = camera.axes
    away = points - camera.eye
    depth = away @ camera.forward * np.tan(np.radians(camera.vertical_field) / 2.0)
    across, above = away @ right / depth / ASPECT, away @ up / depth
    return float(max(np.abs(across).max(), np.abs(above).max())), float(np.ptp(above) / 2.0)


MOTIONS: dict[str, Callable[[float], tuple[float, float, float]]] = {
    "rests": lambda t: (0.0, 0.0, 0.0),
    "walks away": lambda t: (0.5 * t, 2.0 * t, 0.0),
    "is kicked": lambda t: (6.0 * max(0.0, t - 0.5), 0.0, 0.0),
    "bounces": lambda t: (t, 0.0, 2.0 * abs(np.sin(4.0 * t))),
    "shuttles": lambda t: (2.0 * np.sin(3.0 * t), 0.0, 0.0),
}


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("fps", [24.0, 60.0])
def test_a_follower_keeps_the_body_in_the_picture_and_large(name: str, fps: float) -> None:
    path = camera_path("camera", "follow", BODY, ASPECT)
    for index in range(round(3.0 * fps)):
        points = BODY + MOTIONS[name](index / fps)
        out, height = seen(path.at(index / fps, points), points)
        assert out < 1.0 and height > 0.2


def test_a_follower_of_a_body_at_rest_stands_still() -> None:
    path = camera_path("camera", "follow", BODY, ASPECT)
    eyes = [path.at(index / 30.0, BODY).eye for index in range(60)]
    np.testing.assert_allclose(eyes, np.broadcast_to(eyes[0], (60, 3)), atol=1e-12)


def test_a_follower_bears_a_frame_twice_and_begins_anew_before_it() -> None:
    """A movie may show a frame for longer, or a run after another one."""
    path = camera_path("camera", "follow", BODY, ASPECT)
    first = path.at(0.0, BODY)
    moved = BODY + np.array([1.0, 0.0, 0.0])
    there = path.at(0.5, moved)
    np.testing.assert_array_equal(path.at(0.5, moved).eye, there.eye)
    np.testing.assert_array_equal(path.at(0.0, BODY).eye, first.eye)


def test_a_follower_moves_along_without_jerks() -> None:
    """A body at constant speed: once that is taken up, the eye moves by the same way a frame."""
    path = camera_path("camera", "follow", BODY, ASPECT)
    eyes = np.array(
        [path.at(k / 30.0, BODY + np.array([k / 30.0, 0.0, 0.0])).eye for k in range(120)]
    )
    ways = np.diff(eyes, axis=0)
    np.testing.assert_allclose(ways[90:], np.broadcast_to((1 / 30.0, 0, 0), (29, 3)), atol=2e-4)
    assert np.abs(np.diff(ways, axis=0)).max() < 0.01


def test_a_camera_stands_where_it_is_told() -> None:
    still = camera_path("camera", "still", BODY, ASPECT)
    assert not still.moves
    placed = camera_path("camera", (3.0, -4.0, 2.0), BODY, ASPECT).at(0.0, BODY)
    assert placed.eye.tolist() == [3.0, -4.0, 2.0]
    assert seen(placed, BODY.mean(axis=0, keepdims=True))[0] < 0.3
    own = Camera(eye=np.zeros(3), forward=np.array([0.0, 1.0, 0.0]))
    assert camera_path("camera", own, BODY, ASPECT).at(1.0, BODY + 9.0) is own


@pytest.mark.parametrize(
    "choice", ["fellow", None, 3, (1.0, 2.0), (1.0, 2.0, np.nan), "1,2,3", np.zeros((3, 3))]
)
def test_no_camera_is_refused(scene: Scene, tmp_path: Path, choice: Any) -> None:
    with pytest.raises(InputError, match="camera of a StageWriter"):
        StageWriter(tmp_path / "take.usdc", scene, camera=choice)
    assert list(tmp_path.iterdir()) == []


def test_a_camera_right_above_has_no_upright_picture(scene: Scene, tmp_path: Path) -> None:
    low, high = scene.character.mesh.points.min(axis=0), scene.character.mesh.points.max(axis=0)
    x, y, _ = ((low + high) / 2.0).tolist()
    with pytest.raises(InputError, match="not right above or below"):
        StageWriter(tmp_path / "take.usdc", scene, camera=(x, y, 9.0))


def framed(path: Path, name: str) -> list[str]:
    """Frames of a stage whose camera does not see all of the bodies, or less than a fifth high."""
    stage = Usd.Stage.Open(str(path))
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    skins = [prim.GetAttribute("points") for prim in stage.Traverse() if prim.GetName() == "Skin"]
    wrong = []
    for code in skins[0].GetTimeSamples():
        frustum = camera.GetCamera(code).frustum
        matrix = np.array(frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix())
        points = np.concatenate([np.array(skin.Get(code)) for skin in skins])
        seen = np.column_stack([points, np.ones(len(points))]) @ matrix
        flat = seen[:, :2] / seen[:, 3:]
        out, height = np.abs(flat).max(), np.ptp(flat[:, 1]) / 2.0
        if out >= 1.0 or height <= 0.2 or seen[:, 3].min() <= 0.0:
            wrong.append(f"{name} at {code:g}: {out:.2f} of the way out, {height:.2f} high")
    return wrong


def filmed(folder: Path, name: str, seconds: float | None) -> list[str]:
    """What is wrong with the camera of a run of a scene, of its own length by default."""
    plan = scenes.make(name)
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    with StageWriter(folder / f"{name}.usdc", plan.scene) as writer:
        for frame in simulation.run(plan.seconds if seconds is None else seconds):
            writer.write(frame)
    return framed(folder / f"{name}.usdc", name)


@pytest.mark.parametrize(("name", "seconds"), [("bounce-ball", 1.2), ("roll-o", 1.5)])
def test_the_camera_of_a_stage_sees_the_body_in_every_frame(
    tmp_path: Path, name: str, seconds: float
) -> None:
    assert filmed(tmp_path, name, seconds) == []


@pytest.mark.parametrize("name", scenes.names())
def test_the_camera_sees_every_scene_s_start(tmp_path: Path, name: str) -> None:
    assert filmed(tmp_path, name, 0.1) == []


@pytest.mark.long
@pytest.mark.parametrize("name", scenes.names())
def test_the_camera_sees_every_scene_to_its_end(tmp_path: Path, name: str) -> None:
    assert filmed(tmp_path, name, None) == []


def test_a_camera_that_stands_still_loses_a_body_that_rolls_away(tmp_path: Path) -> None:
    """The check finds what it is for."""
    plan = scenes.make("roll-o")
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    with StageWriter(tmp_path / "take.usdc", plan.scene, camera=(0.5, -1.0, 0.5)) as writer:
        for frame in simulation.run(0.1):
            writer.write(frame)
    assert framed(tmp_path / "take.usdc", "roll-o")
