"""A good file is found good, and each kind of damage is named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Vt

from tests.stage_exports.crowd import NAMES
from warp_softbody.stage_exports import validate

SKIN = "/World/block/Skin"
TETS = "/World/block/Tets"


@pytest.mark.parametrize("extension", [".usdc", ".usda"])
def test_an_exported_take_has_no_fault(write_take: Any, extension: str) -> None:
    assert validate(write_take(f"good{extension}")) == []


def _wrong_extent(layer: Any) -> None:
    box = Vt.Vec3fArray([Gf.Vec3f(0.0), Gf.Vec3f(1.0)])
    layer.SetTimeSample(f"{SKIN}.extent", 2.0, box)


def _index_out_of_range(layer: Any) -> None:
    tets = layer.GetAttributeAtPath(f"{TETS}.tetVertexIndices")
    indices = np.array(tets.default)
    indices[3, 1] = 1000
    tets.default = Vt.Vec4iArray.FromNumpy(indices)


def _double_points(layer: Any) -> None:
    prim = layer.GetPrimAtPath(SKIN)
    points = layer.GetAttributeAtPath(f"{SKIN}.points").default
    prim.RemoveProperty(prim.properties["points"])
    attribute = Sdf.AttributeSpec(prim, "points", Sdf.ValueTypeNames.Point3dArray)
    attribute.default = Vt.Vec3dArray.FromNumpy(np.array(points, dtype=np.float64))


def _moving_topology(layer: Any) -> None:
    faces = layer.GetAttributeAtPath(f"{SKIN}.faceVertexIndices")
    layer.SetTimeSample(faces.path, 1.0, faces.default)


def _frozen_motion(layer: Any) -> None:
    path = f"{TETS}.points"
    for code in layer.ListTimeSamplesForPath(path):
        layer.SetTimeSample(path, code, layer.QueryTimeSample(path, 0.0))


def _too_few_velocities(layer: Any) -> None:
    layer.SetTimeSample(f"{TETS}.primvars:velocity", 4.0, Vt.Vec3fArray([Gf.Vec3f(0.0)]))


def _wrong_clock(layer: Any) -> None:
    layer.endTimeCode = 99.0


def _wrong_units(layer: Any) -> None:
    layer.pseudoRoot.SetInfo("metersPerUnit", 0.01)


def _dangling_material(layer: Any) -> None:
    layer.GetPrimAtPath(SKIN).ClearInfo("apiSchemas")


@pytest.mark.parametrize(
    ("damage", "word"),
    [
        (_wrong_extent, "extent"),
        (_index_out_of_range, "out of the range"),
        (_double_points, "not float3"),
        (_moving_topology, "changes its faceVertexIndices"),
        (_frozen_motion, "same in every frame"),
        (_too_few_velocities, "1 velocities"),
        (_wrong_clock, "time codes"),
        (_wrong_units, "metre"),
        (_dangling_material, "MaterialBindingAPI"),
    ],
)
def test_damage_is_named(write_take: Any, damage: Callable[[Any], None], word: str) -> None:
    path: Path = write_take("damaged.usda")
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    damage(layer)
    layer.Export(str(path))
    assert any(word in sentence for sentence in validate(path)), validate(path)


def test_what_is_no_stage_is_said_to_be_none(tmp_path: Path) -> None:
    assert "not a USD file" in validate(tmp_path / "missing.usdc")[0]


@pytest.mark.parametrize("extension", [".usdc", ".usda"])
def test_a_stage_of_several_bodies_has_no_fault(write_crowd: Any, extension: str) -> None:
    assert validate(write_crowd(f"good{extension}")) == []


def _damaged(path: Path, damage: Callable[[Any], None]) -> list[str]:
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    damage(layer)
    layer.Export(str(path))
    return validate(path)


def _freeze(layer: Any, *bodies: str, parts: tuple[str, ...] = ("Skin", "Tets")) -> None:
    for path in (f"/World/{body}/{part}" for body in bodies for part in parts):
        for name in ("points", "extent"):
            first = layer.QueryTimeSample(f"{path}.{name}", 0.0)
            for code in layer.ListTimeSamplesForPath(f"{path}.{name}"):
                layer.SetTimeSample(f"{path}.{name}", code, first)


def test_damage_to_a_later_body_is_named(write_crowd: Any) -> None:
    box_of_others = Vt.Vec3fArray([Gf.Vec3f(0.0), Gf.Vec3f(1.0)])
    found = _damaged(
        write_crowd("wrong.usda"),
        lambda layer: layer.SetTimeSample("/World/cube/Skin.extent", 2.0, box_of_others),
    )
    assert any(s.startswith("/World/cube/Skin") and "extent" in s for s in found), found


def test_a_body_may_stand_still_but_not_half_of_it_nor_all_bodies(write_crowd: Any) -> None:
    path = write_crowd("still.usda")
    assert _damaged(path, lambda layer: _freeze(layer, "cube")) == []
    found = _damaged(path, lambda layer: _freeze(layer, "bar", parts=("Tets",)))
    assert found == ["/World/bar/Tets is the same in every frame"]
    found = _damaged(path, lambda layer: _freeze(layer, *NAMES))
    assert len(found) == 6 and all("same in every frame" in sentence for sentence in found)
