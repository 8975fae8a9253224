"""A stage says what its bodies are made of, so that another program can simulate them again.

Gravity, ground and friction are in USD's own physics schemas; deformable bodies are in those that
are proposed for it (`physics_names.py`). Muscles and what drives them have none.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, UsdGeom, UsdPhysics, UsdShade

from warp_softbody.body.material import Material
from warp_softbody.body.region_materials import tet_owners
from warp_softbody.stage_exports import conventions
from warp_softbody.stage_exports.bodies import StagedBody
from warp_softbody.stage_exports.usd import usd_arrays as values
from warp_softbody.stage_exports.usd.physics_names import NAMES, PhysicsNames, Profile
from warp_softbody.world.scene import Scene

_TYPES = Sdf.ValueTypeNames
PHYSICS = "physics"
"""Purpose of the binding of what is simulated."""


def define_physics(
    stage: Any, scene: Scene, bodies: Sequence[StagedBody], profile: Profile
) -> None:
    """Author gravity, what a ground is and what each body is; with "none" nothing."""
    if profile == "none":
        return
    _define_gravity(stage, scene)
    if scene.ground is not None:
        _define_ground(stage, scene.ground.friction)
    for body in bodies:
        _define_body(stage, body, NAMES[profile])


def _define_gravity(stage: Any, scene: Scene) -> None:
    gravity = np.array(scene.gravity)
    size = float(np.linalg.norm(gravity))
    physics = UsdPhysics.Scene.Define(stage, conventions.PHYSICS)
    direction = gravity / size if size > 0.0 else np.array([0.0, 0.0, -1.0])
    physics.CreateGravityDirectionAttr(Gf.Vec3f(*direction.tolist()))
    physics.CreateGravityMagnitudeAttr(size)


def _define_ground(stage: Any, friction: float) -> None:
    """The ground collides; its friction is on its first material, and on those of its parts."""
    ground = stage.GetPrimAtPath(conventions.GROUND)
    UsdPhysics.CollisionAPI.Apply(ground)
    UsdPhysics.MeshCollisionAPI.Apply(ground).CreateApproximationAttr(UsdPhysics.Tokens.none)
    _bind_friction(ground, friction)
    for part in ground.GetChildren():
        own = part.GetAttribute(conventions.GROUND_FRICTION)
        if own:
            _bind_friction(part, float(own.Get()))


def _bind_friction(prim: Any, friction: float) -> None:
    """The material of a ground, or of a part of it, has its friction."""
    binding = UsdShade.MaterialBindingAPI(prim)
    material, _ = binding.ComputeBoundMaterial()
    surface = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    surface.CreateStaticFrictionAttr(friction)
    surface.CreateDynamicFrictionAttr(friction)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, PHYSICS)


def _define_body(stage: Any, body: StagedBody, names: PhysicsNames) -> None:
    path = conventions.character_path(body.character.name)
    stage.GetPrimAtPath(path).AddAppliedSchema(names.body)
    mesh = body.character.mesh
    tets = stage.GetPrimAtPath(f"{path}/{conventions.TETS}")
    tets.AddAppliedSchema(names.simulation)
    UsdPhysics.CollisionAPI.Apply(tets)
    _set(tets, names.attribute("restShapePoints"), _TYPES.Point3fArray, values.vectors(mesh.points))
    rest = values.quadruples(mesh.tets)
    _set(tets, names.attribute("restTetVtxIndices"), _TYPES.Int4Array, rest)
    path = f"{conventions.MATERIALS}/{body.character.name}"
    # its skin has it already
    material = UsdShade.Material(stage.GetPrimAtPath(path))
    _describe(material, body.character.material, names)
    binding = UsdShade.MaterialBindingAPI.Apply(tets)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, PHYSICS)
    _define_regions(stage, body, binding, names)


def _define_regions(stage: Any, body: StagedBody, binding: Any, names: PhysicsNames) -> None:
    """A subset of the tets, with a material of its own, for each region that has one."""
    own = body.character
    if not own.materials:
        return
    mesh = own.mesh
    owners = tet_owners(mesh.tets, len(mesh.points), own.materials, own.regions)
    for number, (region, given) in enumerate(own.materials.items()):
        chosen = np.flatnonzero(owners == number)
        if not len(chosen):  # all are those of a region that is named later
            continue
        tets = values.integers(chosen)
        name = f"{Tf.MakeValidIdentifier(region)}_{number}"
        material = UsdShade.Material.Define(stage, f"{conventions.MATERIALS}/{own.name}_{name}")
        _describe(material, given, names)
        subset = binding.CreateMaterialBindSubset(name, tets, UsdGeom.Tokens.tetrahedron)
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(
            material, UsdShade.Tokens.weakerThanDescendants, PHYSICS
        )
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.nonOverlapping)


def _describe(material: Any, given: Material, names: PhysicsNames) -> None:
    """Tell of a material what something is made of."""
    prim = material.GetPrim()
    prim.AddAppliedSchema(names.material)
    for name, value in (
        ("youngsModulus", given.young_modulus),
        ("poissonsRatio", given.poisson_ratio),
        ("density", given.density),
    ):
        _set(prim, names.attribute(name), _TYPES.Float, value)


def _set(prim: Any, name: str, kind: Any, value: Any) -> None:
    prim.CreateAttribute(name, kind, custom=False).Set(value)
