"""Several bodies in one stage, each read back as what was its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Kind, Usd, UsdGeom

from tests.stage_exports.crowd import FRAMES, NAMES, SPEEDS, frame_at, moved
from warp_softbody import Simulation
from warp_softbody.cli.run_files import RunFiles
from warp_softbody.errors import InputError
from warp_softbody.stage_exports import StageWriter, body_names, measure, read_take, validate
from warp_softbody.stage_exports.layout import Layout
from warp_softbody.world.joined_bodies import Body
from warp_softbody.world.scene import Scene


def test_each_body_reads_back_what_was_its_own(crowd: Scene, write_crowd: Any) -> None:
    path = write_crowd()
    assert body_names(path) == NAMES
    for character, part in zip(crowd.characters, crowd.parts, strict=True):
        take = read_take(path, character.name)
        assert take.name == character.name and len(take) == FRAMES and take.ground == crowd.ground
        np.testing.assert_allclose(take.color, character.color, atol=1e-7)
        np.testing.assert_array_equal(take.tets, character.mesh.tets)
        np.testing.assert_array_equal(take.rest, np.float32(character.mesh.points))
        for index in range(FRAMES):
            frame = frame_at(crowd, index)
            own = frame.positions[part.nodes]
            np.testing.assert_array_equal(take.tet_points[index], np.float32(own))
            np.testing.assert_array_equal(
                take.velocities[index], np.float32(frame.velocities[part.nodes])
            )
            np.testing.assert_array_equal(
                take.skin_points[index], np.float32(own[Layout.of(character).skin_nodes])
            )
            np.testing.assert_array_equal(
                take.activations[index], np.float32(frame.activations[part.segments])
            )
            heads = [moved(character, f.vertices, frame.time)[:-1] for f in character.fibers]
            np.testing.assert_array_equal(
                take.fiber_points[index, :, 0], np.array(heads, dtype=np.float32).reshape(-1, 3)
            )


def test_contacts_go_to_the_body_whose_node_touches(crowd: Scene, write_crowd: Any) -> None:
    path = write_crowd()
    for character, part in zip(crowd.characters, crowd.parts, strict=True):
        take = read_take(path, character.name)
        for index in range(FRAMES):
            whole = frame_at(crowd, index).contacts
            own = [
                k for k, node in enumerate(whole.nodes) if node in range(*part.nodes.indices(999))
            ]
            assert len(own) == min(index, 3)
            written = take.contacts[index]
            np.testing.assert_array_equal(written.points, np.float32(whole.points[own]))
            np.testing.assert_array_equal(written.modes, whole.modes[own])
            np.testing.assert_array_equal(written.forces, whole.forces[own])


def test_a_run_reaches_the_stage_body_by_body(crowd: Scene, tmp_path: Path) -> None:
    """The engine's own frames: three bodies that begin on the ground."""
    path = tmp_path / "run.usdc"
    with RunFiles(crowd, fps=60.0, stage=path) as recorder:
        frames = list(Simulation(crowd, fps=60.0).run(0.1))
        for frame in frames:
            recorder.write(frame)
    assert validate(path) == []
    for part in crowd.parts:
        take = read_take(path, part.name)
        assert len(take.contacts[-1].points) > 0
        for index, frame in enumerate(frames):
            own = np.float32(frame.positions[part.nodes])
            np.testing.assert_array_equal(take.tet_points[index], own)
            nodes = frame.contacts.nodes
            nodes = nodes[(nodes >= part.nodes.start) & (nodes < part.nodes.stop)]
            np.testing.assert_array_equal(
                take.contacts[index].points, own[nodes - part.nodes.start]
            )


def test_the_first_body_is_the_one_read_without_a_name(write_crowd: Any) -> None:
    path = write_crowd()
    assert read_take(path).name == "tower"
    with pytest.raises(InputError, match=r"no body 'horse'; it holds: tower, bar, cube"):
        read_take(path, "horse")


def test_each_body_is_measured_alone(crowd: Scene, write_crowd: Any) -> None:
    """Positions near 1 m in single precision: a few millionths."""
    path = write_crowd()
    for name in NAMES:
        measures = measure(read_take(path, name))
        way = measures.centre_of_mass - measures.centre_of_mass[0]
        expected = np.arange(FRAMES)[:, None] / 30.0 * np.array(SPEEDS[name])
        np.testing.assert_allclose(way, expected, atol=2e-6)
        np.testing.assert_allclose(measures.smallest_volume_ratio, 1.0, atol=1e-4)


def test_every_body_is_a_component_of_its_own(write_crowd: Any) -> None:
    stage = Usd.Stage.Open(str(write_crowd()))
    children = {
        name: [prim.GetName() for prim in stage.GetPrimAtPath(f"/World/{name}").GetChildren()]
        for name in NAMES
    }
    assert children == {
        "tower": ["Skin", "Tets", "Contacts"],
        "bar": ["Skin", "Tets", "Fibers", "Contacts"],
        "cube": ["Skin", "Tets", "Contacts"],
    }
    for name in NAMES:
        assert (
            Usd.ModelAPI(stage.GetPrimAtPath(f"/World/{name}")).GetKind() == Kind.Tokens.component
        )
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera")).GetCamera(0)
    view = camera.frustum.ComputeViewMatrix() * camera.frustum.ComputeProjectionMatrix()
    for name in NAMES:
        for point in stage.GetPrimAtPath(f"/World/{name}/Skin").GetAttribute("points").Get():
            assert np.abs(np.array(view.Transform(point))).max() < 1.0


@pytest.mark.parametrize(
    ("change", "expected"),
    [({}, True), ({"others": ()}, False), ({"others": (), "self_contact": True}, True)],
    ids=["others", "alone", "self-contact"],
)
def test_in_free_space_only_what_can_touch_has_contacts(
    crowd: Scene, tmp_path: Path, change: dict[str, Any], expected: bool
) -> None:
    scene = replace(crowd, ground=None, **change)
    with StageWriter(tmp_path / "free.usda", scene) as stage:
        stage.write(frame_at(scene, 0))
    written = Usd.Stage.Open(str(tmp_path / "free.usda"))
    assert bool(written.GetPrimAtPath("/World/tower/Contacts")) == expected


def test_another_program_reads_every_skin(crowd: Scene, write_crowd: Any) -> None:
    tinyusdz = pytest.importorskip("tinyusdz")
    stage = tinyusdz.load(str(write_crowd()))
    for character in crowd.characters:
        skin = stage.get_prim_at_path(f"/World/{character.name}/Skin")
        samples = skin.get_attribute_timesamples("points")
        assert [code for code, _ in samples] == list(range(FRAMES))
        for code, points in samples:
            surface = character.mesh.points[Layout.of(character).skin_nodes]
            expected = moved(character, surface, code / 30.0)
            np.testing.assert_array_equal(np.asarray(points), np.float32(expected))


@pytest.mark.parametrize(
    ("nodes", "sentence"),
    [
        ([], r"contact nodes must have the shape \(3,\)"),
        ([0, 1, 999], "a contact node is not one of the"),
        ([0, 1, -1], "a contact node is not one of the"),
    ],
)
def test_contacts_of_no_body_are_refused(
    crowd: Scene, tmp_path: Path, nodes: list[int], sentence: str
) -> None:
    frame = frame_at(crowd, 1)
    contacts = replace(frame.contacts, nodes=np.array(nodes, dtype=np.int32))
    with StageWriter(tmp_path / "strict.usdc", crowd) as stage:
        with pytest.raises(InputError, match=sentence):
            stage.write(replace(frame, contacts=contacts))


def test_no_body_takes_a_name_of_the_stage(crowd: Scene, tmp_path: Path) -> None:
    other = Body(character=replace(crowd.character, name="Camera"))
    with pytest.raises(InputError, match="cannot be named 'Camera'"):
        StageWriter(tmp_path / "taken.usdc", replace(crowd, others=(other,)))
