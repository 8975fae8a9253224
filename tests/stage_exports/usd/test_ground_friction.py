"""Stages tell and show where a ground is rough and where it is smooth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade

from warp_softbody.stage_exports import StageWriter, read_take, validate
from warp_softbody.stage_exports.conventions import FRICTION_FACTORS, GROUND_FRICTION, MEANINGS
from warp_softbody.stage_exports.palette import friction_shade
from warp_softbody.world.friction_map import FrictionMap
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene
from warp_softbody.world.triangle_ground import TriangleGround

PLACED = FrictionMap.stripes([1.0, 0.25, 1.5], width=0.5, start=-0.5)
HEIGHTS = HeightField(
    heights=np.zeros((9, 5)), spacing=(0.25, 0.5), origin=(-1.0, -1.0), friction=0.4
)
GROUNDS: list[Ground] = [
    Plane(friction=0.4, friction_map=PLACED),
    replace(HEIGHTS, friction_map=PLACED),
    TriangleGround(
        vertices=HEIGHTS.triangles()[0],
        faces=HEIGHTS.triangles()[1],
        friction=0.4,
        friction_map=PLACED,
    ),
]


def written(scene: Scene, ground: Ground, make_frames: Any, path: Path) -> Path:
    placed = replace(scene, ground=ground)
    with StageWriter(path, placed) as writer:
        writer.write(next(iter(make_frames(placed))))
    return path


@pytest.mark.parametrize("ground", GROUNDS, ids=lambda ground: type(ground).__name__)
def test_a_map_comes_back_from_a_stage(
    ground: Ground, scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = written(scene, ground, make_frames, tmp_path / "take.usda")
    assert read_take(path).ground == ground
    assert validate(path) == []


@pytest.mark.parametrize("ground", GROUNDS, ids=lambda ground: type(ground).__name__)
def test_every_face_has_the_colour_and_the_material_of_its_friction(
    ground: Ground, scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = written(scene, ground, make_frames, tmp_path / "take.usda")
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Ground"))
    prim = mesh.GetPrim()
    told = prim.GetAttribute(FRICTION_FACTORS)
    assert told.GetDocumentation() == MEANINGS[FRICTION_FACTORS]
    points = np.array(mesh.GetPointsAttr().Get())
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get())
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(len(counts), -1)
    factors = PLACED.at(points[faces].mean(axis=1))
    subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
    chosen = [np.array(subset.GetIndicesAttr().Get()) for subset in subsets]
    assert sorted(np.concatenate(chosen).tolist()) == list(range(len(faces)))
    for subset, own in zip(subsets, chosen, strict=True):
        friction = subset.GetPrim().GetAttribute(GROUND_FRICTION).Get()
        np.testing.assert_allclose(0.4 * factors[own], friction, rtol=1e-12)
        material, _ = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial("physics")
        physics = material.GetPrim().GetAttribute("physics:dynamicFriction").Get()
        assert physics == pytest.approx(friction, rel=1e-6)
    colors = np.array(mesh.GetDisplayColorAttr().Get())
    bright = [colors[factors == factor].max() for factor in (1.0, 0.25, 1.5)]
    np.testing.assert_allclose(bright / bright[0], friction_shade([1.0, 0.25, 1.5]), rtol=1e-5)


def test_many_levels_are_put_together(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    factors = np.linspace(0.0, 2.0, 40).reshape(8, 5)
    placed = FrictionMap(factors=factors, spacing=(0.25, 0.5), origin=(-1.0, -1.0))
    ground = replace(HEIGHTS, friction_map=placed)
    path = written(scene, ground, make_frames, tmp_path / "take.usda")
    assert read_take(path).ground == ground
    stage = Usd.Stage.Open(str(path))
    prim = stage.GetPrimAtPath("/World/Ground")
    subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
    assert 4 < len(subsets) <= 8


def test_a_map_that_lacks_its_rows_is_no_ground(
    scene: Scene, make_frames: Any, tmp_path: Path
) -> None:
    path = written(scene, GROUNDS[0], make_frames, tmp_path / "take.usda")
    text = path.read_text().replace("softbody:frictionRows", "softbody:frictionLines")
    path.write_text(text)
    with pytest.raises(Exception, match="map of friction has no rows"):
        read_take(path)
