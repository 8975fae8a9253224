"""Characters of strangers' surfaces: units and axes, limbs and feet, fibres within the body."""

from __future__ import annotations

import warnings
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from tests.support.surfaces import BODIES, biped, capsule
from warp_softbody import Character, TetMesh
from warp_softbody.body.making.from_surface import made_from_surface
from warp_softbody.body.making.limb_fibers import _frames, _tangents
from warp_softbody.body.making.limbs import Limb
from warp_softbody.body.making.made import Made
from warp_softbody.body.point_location import locate
from warp_softbody.errors import InputError, MeshError, MeshWarning

UNITS = {"m": 1.0, "cm": 100.0, "mm": 1000.0, "inch": 1.0 / 0.0254}
UPS = {"z": (0, 1, 2), "y": (1, 2, 0), "x": (2, 0, 1)}
"""Which coordinate of the body each column of the file has, by the file's upward axis."""

LIMBS = {"letter_y": 3, "table": 4, "starfish": 5, "quadruped": 5, "biped": 5}
FEET = {"table": 4, "quadruped": 4, "chair": 4, "biped": 2}


@cache
def made(name: str) -> Made:
    """A body, in one of several units and axes."""
    number = list(BODIES).index(name)
    unit, up = list(UNITS)[number % 4], list(UPS)[number % 3]
    surface = BODIES[name]()
    surface.vertices = UNITS[unit] * np.array(surface.vertices)[:, UPS[up]]
    forward = {"z": "x", "y": "z", "x": "y"}[up]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return made_from_surface(surface, name=name, unit=unit, up=up, forward=forward)


@pytest.mark.parametrize("name", BODIES)
def test_becomes_a_character_of_its_size(name: str) -> None:
    character = Character(**made(name).parts)
    given = BODIES[name]()
    sides = np.ptp(given.vertices, axis=0)
    assert np.ptp(character.mesh.points, axis=0) == pytest.approx(sides, rel=0.08, abs=0.02)
    assert character.mesh.points[:, 2].min() == 0.0
    assert character.mesh.part_count == 1
    assert character.mesh.smallest_dihedral_angle > 5.0
    assert len(character.region("base")) and len(character.region("head"))


@pytest.mark.parametrize("name", BODIES)
def test_fibres_lie_within_the_body(name: str) -> None:
    mesh = made(name).mesh
    for group in made(name).muscles:
        for fiber in group.fibers:
            assert locate(mesh.points, mesh.tets, fiber.vertices).weights.min() > -1e-6
    assert 40 <= sum(group.segment_count for group in made(name).muscles) <= 110


@pytest.mark.parametrize("name", LIMBS)
def test_finds_the_limbs(name: str) -> None:
    assert len([limb for limb in made(name).limbs if limb.ends]) == LIMBS[name]


@pytest.mark.parametrize("name", FEET)
def test_finds_the_feet(name: str) -> None:
    assert (
        len([region for region in made(name).regions if region.startswith("foot_")]) == FEET[name]
    )


def test_a_ring_that_lies_has_no_feet() -> None:
    """It touches the floor at single nodes of a circle, which low skin joins."""
    ring = BODIES["torus"]()
    ring.vertices = np.array(ring.vertices)[:, [0, 2, 1]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        regions = made_from_surface(ring, name="ring", tets=800).regions
    assert [name for name in regions if name.startswith("foot_")] == []
    assert all(len(regions[f"base_patch_{k}"]) for k in range(4))


def test_limbs_of_a_mirrored_body_mirror_each_other() -> None:
    limbs = [limb for limb in made("quadruped").limbs if limb.axis[-1, 2] < 0.2]
    assert len(limbs) == 4
    left, right = (sum(limb.length for limb in limbs if s * limb.axis[-1, 1] > 0) for s in (-1, 1))
    assert left == pytest.approx(right, rel=0.1)


def test_the_same_surface_gives_the_same_character() -> None:
    with pytest.warns(MeshWarning, match="parts united"):
        one = Character.from_surface(biped(), tets=500)
    with pytest.warns(MeshWarning, match="parts united"):
        other = Character.from_surface(biped(), tets=500)
    assert one == other


def test_a_height_sets_the_size() -> None:
    character = Character.from_surface(capsule(), height=0.3, tets=400)
    assert character.mesh.points[:, 2].max() == pytest.approx(0.3, rel=0.02)


def test_a_body_a_hundred_metres_high_is_asked_about() -> None:
    surface = capsule()
    surface.apply_scale(100.0)
    with pytest.raises(InputError, match=r"100 m high is hardly what is meant; give its unit"):
        Character.from_surface(surface)
    assert Character.from_surface(surface, unit="cm", tets=400).mesh.volume < 0.2


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"unit": "yard"}, "unit"),
        ({"unit": "cm", "height": 1.0}, "not by both"),
        ({"up": "w"}, "up of a surface"),
        ({"up": "y", "forward": "-y"}, "perpendicular"),
        ({"tets": 3}, "tets of a character"),
        ({"repair": "some"}, "repair of a surface"),
        ({"density": -1.0}, "density"),
        ({"height": 0.0}, "height"),
        ({"name": "a b"}, "name of a character"),
    ],
)
def test_wrong_values_are_refused(arguments: dict[str, object], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        made_from_surface(capsule(), **arguments)  # type: ignore[arg-type]


def test_a_flawed_surface_may_be_refused() -> None:
    with pytest.raises(MeshError, match=r"repair is 'none': 'auto' would have \d+ parts united"):
        made_from_surface(biped(), repair="none")


def test_files_keep_their_unit_and_axis(tmp_path: Path) -> None:
    surface = capsule()
    surface.vertices = np.array(surface.vertices)[:, UPS["y"]]
    path = tmp_path / "my body-2.glb"
    surface.export(path)
    character = Character.from_surface(path, tets=400)
    assert character.name == "my_body_2"
    assert character.mesh.points[:, 2].max() == pytest.approx(1.0, rel=0.05)


def test_a_textured_file_is_the_skin_in_its_place(tmp_path: Path) -> None:
    surface = capsule()
    surface.vertices = np.array(surface.vertices)[:, UPS["y"]] * (1.0, 1.0, 0.5)
    picture = Image.new("RGB", (4, 4), (200, 40, 40))
    places = np.array(surface.vertices)[:, :2]
    visuals: Any = trimesh.visual.TextureVisuals  # its types are not told
    surface.visual = visuals(uv=places, image=picture)
    surface.export(tmp_path / "body.glb")
    character = Character.from_surface(tmp_path / "body.glb", tets=600)
    assert character.skin is not None and character.skin.textured
    skin, mesh = character.skin.points, character.mesh.points
    assert np.ptp(skin, axis=0) == pytest.approx(np.ptp(mesh, axis=0), abs=0.03)
    assert skin.min(axis=0) == pytest.approx(mesh.min(axis=0), abs=0.03)


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "body.glb"
    capsule().export(path)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(MeshError, match=r"body\.glb: cannot be read as a \.glb surface"):
        Character.from_surface(path)


def test_a_tet_mesh_is_kept_with_its_regions() -> None:
    mesh = made("capsule").mesh
    named = TetMesh(mesh.points, mesh.tets, regions={"heart": np.array([0, 1], dtype=np.int32)})
    character = Character.from_surface(named, height=2.0)
    assert len(character.mesh.tets) == len(mesh.tets)
    assert character.mesh.points[:, 2].max() == pytest.approx(2.0)
    assert list(character.region("heart")) == [0, 1]
    with pytest.raises(InputError, match="a tet mesh is kept as it is"):
        Character.from_surface(named, tets=500)


def test_an_axis_that_turns_back_has_tangents() -> None:
    """A loop of two slices: out and back by the same way."""
    axis = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    assert _tangents(axis) == pytest.approx(np.array([[0, 0, 1], [0, 0, 1], [0, 0, -1.0]]))


@pytest.mark.parametrize("bend", [0.0, np.pi / 2, np.pi])
def test_frames_are_at_right_angles_to_any_axis(bend: float) -> None:
    mesh = made("capsule").mesh
    axis = np.array([[0.0, 0.0, 0.5], [0.1, 0.0, 0.5], [0.1, 0.0, 0.5]])
    axis[2] += 0.1 * np.array([np.cos(bend), 0.0, np.sin(bend)])
    limb = Limb(axis, np.arange(len(mesh.points)), 0.2, ends=True)
    frames = _frames(mesh, limb, axis)
    assert np.isfinite(frames).all()
    assert np.einsum("skx,sx->sk", frames, _tangents(axis)) == pytest.approx(0.0, abs=1e-12)
    assert np.linalg.norm(frames, axis=2).min() > 0.0
