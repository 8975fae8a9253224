"""Other programs find in a stage what its bodies are made of, and what they stand on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdPhysics, UsdShade

from warp_softbody.errors import InputError
from warp_softbody.stage_exports import StageWriter, validate
from warp_softbody.world.scene import Scene


@pytest.fixture
def write(scene: Scene, make_frames: Any, tmp_path: Path) -> Any:
    def written(**options: Any) -> Any:
        path = tmp_path / "take.usda"
        with StageWriter(path, scene, **options) as writer:
            for frame in make_frames(scene, 3):
                writer.write(frame)
        assert validate(path) == []
        return Usd.Stage.Open(str(path))

    return written


@pytest.mark.parametrize(
    ("profile", "space", "schemas"),
    [
        (
            "newton",
            "physics",
            (
                "PhysicsDeformableBodyAPI",
                "PhysicsVolumeDeformableSimAPI",
                "PhysicsVolumeDeformableMaterialAPI",
            ),
        ),
        (
            "omni",
            "omniphysics",
            (
                "OmniPhysicsDeformableBodyAPI",
                "OmniPhysicsVolumeDeformableSimAPI",
                "OmniPhysicsDeformableMaterialAPI",
            ),
        ),
    ],
)
def test_a_body_says_what_it_is_made_of(
    write: Any, scene: Scene, profile: str, space: str, schemas: tuple[str, str, str]
) -> None:
    stage = write(physics=profile)
    body, tets = (stage.GetPrimAtPath(f"/World/block{name}") for name in ("", "/Tets"))
    material, _ = UsdShade.MaterialBindingAPI(tets).ComputeBoundMaterial("physics")
    for prim, schema in zip((body, tets, material.GetPrim()), schemas, strict=True):
        # schemas that are not registered count all the same
        assert schema in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    given = scene.character.material
    for name, value in (
        ("youngsModulus", given.young_modulus),
        ("poissonsRatio", given.poisson_ratio),
        ("density", given.density),
    ):
        assert material.GetPrim().GetAttribute(f"{space}:{name}").Get() == pytest.approx(value)
    mesh = scene.character.mesh
    rest = np.array(tets.GetAttribute(f"{space}:restShapePoints").Get())
    np.testing.assert_allclose(rest, mesh.points, atol=1e-6)
    indices = np.array(tets.GetAttribute(f"{space}:restTetVtxIndices").Get())
    np.testing.assert_array_equal(indices, mesh.tets)


def test_regions_have_their_own_materials(scene: Scene, make_frames: Any, tmp_path: Path) -> None:
    """As subsets of the tets that do not overlap; where regions do, the one named last counts."""
    body = scene.character
    z = body.mesh.points[:, 2]
    middle = 0.5 * (z.min() + z.max())
    own = replace(
        body,
        regions={
            "all-of-it": np.arange(len(z), dtype=np.int32),
            "covered": np.flatnonzero(z >= middle - 1e-9).astype(np.int32),
            "upper half": np.flatnonzero(z >= middle - 1e-9).astype(np.int32),
        },
        materials={
            "all-of-it": replace(body.material, density=700.0),
            "covered": replace(body.material, density=900.0),
            "upper half": replace(body.material, young_modulus=3e6),
        },
    )
    scene, path = replace(scene, character=own), tmp_path / "take.usda"
    with StageWriter(path, scene) as writer:
        for frame in make_frames(scene, 3):
            writer.write(frame)
    assert validate(path) == []
    stage = Usd.Stage.Open(str(path))
    binding = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(f"/World/{own.name}/Tets"))
    volumes, densities = own.mesh.volumes, np.zeros(len(own.mesh.tets))
    stiffness = np.zeros(len(own.mesh.tets))
    # all tets of "covered" are those of "upper half" too
    assert len(binding.GetMaterialBindSubsets()) == 2
    for subset in binding.GetMaterialBindSubsets():
        assert subset.GetElementTypeAttr().Get() == "tetrahedron"
        material, _ = UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial("physics")
        chosen = np.array(subset.GetIndicesAttr().Get())
        densities[chosen] += material.GetPrim().GetAttribute("physics:density").Get()
        stiffness[chosen] += material.GetPrim().GetAttribute("physics:youngsModulus").Get()
    np.testing.assert_allclose(densities @ volumes, own.node_masses.sum(), rtol=1e-6)
    factors = own.tet_materials.stiffness * own.material.young_modulus
    np.testing.assert_allclose(stiffness, factors, rtol=1e-6)
    assert len(np.unique(factors)) == 2


def test_gravity_and_ground_are_in_usd_s_own_schemas(write: Any, scene: Scene) -> None:
    stage = write()
    physics = UsdPhysics.Scene(stage.GetPrimAtPath("/World/Physics"))
    gravity = physics.GetGravityMagnitudeAttr().Get() * np.array(
        physics.GetGravityDirectionAttr().Get()
    )
    np.testing.assert_allclose(gravity, scene.gravity, rtol=1e-6)
    ground = stage.GetPrimAtPath("/World/Ground")
    assert ground.HasAPI(UsdPhysics.CollisionAPI)
    assert UsdPhysics.MeshCollisionAPI(ground).GetApproximationAttr().Get() == "none"
    material, _ = UsdShade.MaterialBindingAPI(ground).ComputeBoundMaterial("physics")
    friction = UsdPhysics.MaterialAPI(material).GetDynamicFrictionAttr().Get()
    assert friction == pytest.approx(scene.ground.friction if scene.ground else 0.0)


def test_a_stage_without_physics_has_none(write: Any) -> None:
    stage = write(physics="none")
    for prim in stage.Traverse():
        named = [str(name) for name in prim.GetPrimTypeInfo().GetAppliedAPISchemas()]
        assert not any("Physics" in name for name in named)
        assert not prim.IsA(UsdPhysics.Scene)


def test_a_profile_that_is_not_known_is_refused(scene: Scene, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="physics of a StageWriter"):
        StageWriter(tmp_path / "take.usda", scene, physics="mujoco")  # type: ignore[arg-type]
