"""A stage in other forms holds the same motion, as programs that are not ours read it."""

from __future__ import annotations

import xml.etree.ElementTree
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from pxr import Usd

from tests.stage_exports.crowd import FRAMES, NAMES
from warp_softbody.cli import main
from warp_softbody.errors import InputError, OutputError
from warp_softbody.stage_exports import convert, read_take, validate
from warp_softbody.stage_exports.forms.components import components_of
from warp_softbody.stage_exports.forms.glb import TOLERANCE


def test_arrays_are_those_of_the_take(write_crowd: Any, tmp_path: Path) -> None:
    stage = write_crowd()
    with np.load(convert(stage, tmp_path / "crowd.npz")) as stored:
        assert len(stored["times"]) == FRAMES
        for name in NAMES:
            take = read_take(stage, name)
            np.testing.assert_array_equal(stored[f"{name}/points"], take.tet_points)
            np.testing.assert_array_equal(stored[f"{name}/velocities"], take.velocities)
            np.testing.assert_array_equal(stored[f"{name}/tets"], take.tets)
            for index, sample in enumerate(take.contacts):
                rows = stored[f"{name}/contact_frames"] == index
                np.testing.assert_array_equal(stored[f"{name}/contact_forces"][rows], sample.forces)
                np.testing.assert_array_equal(stored[f"{name}/contact_nodes"][rows], sample.nodes)


def test_paraview_finds_every_frame_and_body(write_crowd: Any, tmp_path: Path) -> None:
    stage = write_crowd()
    index = convert(stage, tmp_path / "crowd.pvd")
    # a second time, in place of the first
    assert convert(stage, index) == index
    entries = xml.etree.ElementTree.parse(index).getroot().findall("./Collection/DataSet")
    assert len(entries) == FRAMES * len(NAMES)
    takes = {name: read_take(stage, name) for name in NAMES}
    for entry in entries:
        mesh = meshio.read(tmp_path / entry.attrib["file"])
        take = takes[NAMES[int(entry.attrib["part"])]]
        frame = int(np.argmin(np.abs(take.times - float(entry.attrib["timestep"]))))
        np.testing.assert_allclose(mesh.points, take.tet_points[frame], atol=1e-12)
        np.testing.assert_array_equal(mesh.cells_dict["tetra"], take.tets)
        np.testing.assert_allclose(mesh.point_data["velocity"], take.velocities[frame])
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == ["crowd.pvd", "crowd.usdc", "crowd_frames"]


def test_a_folder_of_something_else_is_left_alone(write_crowd: Any, tmp_path: Path) -> None:
    stage = write_crowd()
    kept = tmp_path / "crowd_frames" / "0001.png"
    kept.parent.mkdir()
    kept.write_text("a picture")
    with pytest.raises(OutputError, match=r"0001\.png"):
        convert(stage, tmp_path / "crowd.pvd")
    assert kept.read_text() == "a picture"
    assert not (tmp_path / "crowd.pvd").exists()


def test_endings_may_be_in_capitals(write_crowd: Any, tmp_path: Path) -> None:
    stage = write_crowd()
    packed = convert(stage, tmp_path / "crowd.USDZ")
    assert packed.read_bytes()[:2] == b"PK"


def values_of(gltf: Any, number: int) -> Any:
    """An accessor's array, decoded from the file's own words alone."""
    accessor = gltf.accessors[number]
    view = gltf.bufferViews[accessor.bufferView]
    kind = {5126: np.float32, 5125: np.uint32}[accessor.componentType]
    raw = gltf.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
    rows = np.frombuffer(raw, kind).reshape(accessor.count, -1)
    if accessor.min:
        np.testing.assert_array_equal(rows.min(axis=0), accessor.min)
        np.testing.assert_array_equal(rows.max(axis=0), accessor.max)
    return rows


def test_glb_moves_every_skin_as_the_stage_does(write_crowd: Any, tmp_path: Path) -> None:
    pygltflib = pytest.importorskip("pygltflib")
    stage = write_crowd()
    gltf = pygltflib.GLTF2().load(str(convert(stage, tmp_path / "crowd.glb")))
    (animation,) = gltf.animations
    tracks = {
        (channel.target.node, channel.target.path): animation.samplers[channel.sampler]
        for channel in animation.channels
    }
    for number, name in enumerate(NAMES, start=1):
        take, node = read_take(stage, name), gltf.nodes[number]
        assert node.name == name
        primitive = gltf.meshes[node.mesh].primitives[0]
        middles = values_of(gltf, tracks[number, "translation"].output)
        points = np.repeat(values_of(gltf, primitive.attributes.POSITION)[None], FRAMES, axis=0)
        targets = [values_of(gltf, target["POSITION"]) for target in primitive.targets]
        if targets:
            weights = values_of(gltf, tracks[number, "weights"].output).reshape(FRAMES, -1)
            assert weights.min() >= 0.0 and weights.max() <= 1.0
            points = points + np.einsum("fc,ckd->fkd", weights, np.array(targets))
        size = float(np.ptp(take.skin_rest, axis=0).max())
        off = np.abs(points + middles[:, None] - take.skin_points).max()
        assert off <= 1.1 * TOLERANCE * size
        faces = values_of(gltf, primitive.indices).reshape(-1, 3)
        np.testing.assert_array_equal(faces, take.skin_faces)
        times = values_of(gltf, tracks[number, "translation"].input)[:, 0]
        np.testing.assert_allclose(times, take.times, atol=1e-6)
    # z up becomes y up
    x, y, z, w = gltf.nodes[0].rotation
    turned = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    np.testing.assert_allclose(turned, [0.0, 1.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("kind", ["usda", "usdc", "usdz"])
def test_another_kind_of_usd_file_is_the_same_stage(
    write_crowd: Any, tmp_path: Path, kind: str
) -> None:
    stage = write_crowd()
    path = convert(stage, tmp_path / f"again.{kind}")
    assert validate(path) == []
    assert Usd.Stage.Open(str(path)).GetDefaultPrim().GetName() == "World"
    for name in NAMES:
        assert read_take(path, name) == read_take(stage, name)


def test_components_are_as_few_as_the_motion_has() -> None:
    rng = np.random.default_rng(3)
    shapes, weights = rng.random((2, 40, 3)), rng.random((25, 2)) - 0.5
    points = 1.0 + np.einsum("fc,ckd->fkd", weights, shapes)
    found = components_of(points, 1e-9)
    assert found.targets.shape[0] == 2
    assert found.weights.min() >= 0.0 and found.weights.max() <= 1.0
    np.testing.assert_allclose(found.points(), points, atol=1e-12)
    assert components_of(points[:1], 1e-9).weights.shape == (1, 0)


def test_what_is_no_stage_and_no_form_is_refused(write_crowd: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not a USD file"):
        convert(tmp_path / "missing.usdc", tmp_path / "a.npz")
    with pytest.raises(OutputError, match="must end in one of"):
        convert(write_crowd(), tmp_path / "a.abc")
    older = tmp_path / "older.npz"
    older.write_bytes(b"older")
    (tmp_path / "broken.usdc").write_bytes(b"PXR-USDC and nothing else")
    with pytest.raises(InputError):
        convert(tmp_path / "broken.usdc", older)
    assert older.read_bytes() == b"older"


def test_the_command_converts(
    write_crowd: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stage = write_crowd()
    assert main(["convert", str(stage), "-o", str(tmp_path / "crowd.npz")]) == 0
    assert "crowd.npz" in capsys.readouterr().out
    assert main(["convert", str(stage), "-o", str(tmp_path / "crowd.abc")]) == 2
    assert "must end in one of" in capsys.readouterr().err
