"""What other programs make of our stages; each has to refuse one that is spoilt.

`make test-viewers` installs them into out/viewers and leaves Blender's pictures there.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tinyusdz
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.viewers.conftest import HOME, RunProgram, StageOf
from warp_softbody import scenes
from warp_softbody.stage_exports import validate

pytestmark = pytest.mark.viewers


def spoilt(stage: Path, change: Callable[[Any], None], name: str) -> Path:
    """A copy of a stage that has been changed."""
    layer = Sdf.Layer.OpenAsAnonymous(str(stage))
    opened = Usd.Stage.Open(layer)
    change(opened)
    path = stage.with_name(f"{stage.stem}-{name}.usdc")
    layer.Export(str(path))
    return path


def skin_of(stage: Any) -> Any:
    return next(UsdGeom.Mesh(p) for p in stage.Traverse() if p.GetName() == "Skin")


def test_the_asset_validator_finds_nothing(program: RunProgram, stage_of: StageOf) -> None:
    """No failure and no error on any scene's stage; without normals or a scheme there is one."""
    stages = [stage_of(name) for name in scenes.names()]

    def flat(stage: Any) -> None:
        skin_of(stage).GetSubdivisionSchemeAttr().Set("none")

    wrong = spoilt(stages[0], flat, "flat")
    found = program("validator", "asset_validator", *stages, wrong)
    assert any("NormalsExistChecker" in issue for issue in found.pop(str(wrong)))
    assert {path: issues for path, issues in found.items() if issues} == {}


def test_usd_s_own_validators_find_nothing(stage_of: StageOf) -> None:
    assert {name: found for name in scenes.names() if (found := validate(stage_of(name)))} == {}

    def unbound(stage: Any) -> None:
        skin_of(stage).GetPrim().RemoveAppliedSchema("MaterialBindingAPI")

    assert validate(spoilt(stage_of("balance-i"), unbound, "unbound")) != []


def test_blender_draws_sharp_edges_and_muscles(program: RunProgram, stage_of: StageOf) -> None:
    """Frame 0 as well, which has contacts of none; a skin whose sides share points is a balloon."""
    pictures = HOME / "pictures"
    for name in ("drop-block", "balance-i"):
        shutil.rmtree(pictures / name, ignore_errors=True)
        (pictures / name).mkdir(parents=True)
        told = program("blender", "blender", stage_of(name), pictures / name, 0, 5)
        # of the cube's flat sides; letter I has none but flat ones at rest either
        assert told["bent"] < 0.35, name
        assert told["curves"] == (1 if name == "balance-i" else 0)
        images = [np.asarray(Image.open(path)) for path in sorted((pictures / name).glob("*.png"))]
        assert len(images) == 2 and all(np.ptp(image[..., :3]) > 100 for image in images)
        assert not np.array_equal(images[0], images[1])
    merged = spoilt(stage_of("drop-block"), merge_sides, "merged")
    (pictures / "merged").mkdir(exist_ok=True)
    assert program("blender", "blender", merged, pictures / "merged", 0)["bent"] > 0.6


def merge_sides(stage: Any) -> None:
    """Let the points of a skin at one place be one."""
    skin = skin_of(stage)
    rest = np.array(skin.GetPointsAttr().Get())
    _, first, number = np.unique(rest, axis=0, return_index=True, return_inverse=True)
    faces = number.reshape(-1)[np.array(skin.GetFaceVertexIndicesAttr().Get())]
    skin.GetFaceVertexIndicesAttr().Set(faces.astype(np.int32).tolist())
    points = skin.GetPointsAttr()
    for code in points.GetTimeSamples():
        points.Set([Gf.Vec3f(*map(float, p)) for p in np.array(points.Get(code))[first]], code)
    points.Set([Gf.Vec3f(*map(float, p)) for p in rest[first]])
    for name in ("cornerIndices", "cornerSharpnesses"):
        skin.GetPrim().RemoveProperty(name)


def test_tydra_converts_every_stage(stage_of: StageOf) -> None:
    for name in scenes.names():
        converted = tinyusdz.tydra.convert_to_render_scene(tinyusdz.load(str(stage_of(name))))
        bodies = scenes.make(name).scene.characters
        assert len(converted.meshes()) >= len(bodies), name

    def beyond(stage: Any) -> None:
        faces = np.array(skin_of(stage).GetFaceVertexIndicesAttr().Get())
        faces[0] = 10**6
        skin_of(stage).GetFaceVertexIndicesAttr().Set(faces.tolist())

    wrong = spoilt(stage_of("balance-i"), beyond, "beyond")
    with pytest.raises(tinyusdz.UsdError):
        tinyusdz.tydra.convert_to_render_scene(tinyusdz.load(str(wrong)))


@pytest.mark.parametrize("name", ["balance-i", "drop-block"])
def test_newton_gets_mass_and_stiffness(program: RunProgram, stage_of: StageOf, name: str) -> None:
    character = scenes.make(name).scene.character
    material = character.material
    found = program("newton", "newton_import", stage_of(name))
    mass = material.density * character.mesh.volumes.sum()
    assert found["mass"] == pytest.approx(mass, rel=1e-3)
    assert found["tets"] == len(character.mesh.tets)
    # E and nu are stored in single precision
    assert found["mu"] == pytest.approx([material.lame_mu], rel=1e-5)
    assert found["lambda"] == pytest.approx([material.lame_lambda], rel=1e-5)
    assert found["shapes"] >= 1

    def heavier(stage: Any) -> None:
        prim = stage.GetPrimAtPath(f"/World/Materials/{character.name}")
        prim.GetAttribute("physics:density").Set(1.01 * material.density)

    spoiled = program("newton", "newton_import", spoilt(stage_of(name), heavier, "heavier"))
    assert spoiled["mass"] != pytest.approx(mass, rel=1e-3)
