"""Soft cubes dropped on each other come to rest as a stack."""

from __future__ import annotations

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.scenes.drop_block import box_mesh
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.world.ground import Plane
from warp_softbody.world.joined_bodies import Body, placed
from warp_softbody.world.scene import Scene

SIDE = 0.3  # m
TURN = 15.0  # degrees, of each cube against the one below
COLORS = ((0.80, 0.30, 0.24), (0.25, 0.48, 0.72), (0.86, 0.62, 0.20), (0.35, 0.60, 0.35))


def build(values: Values) -> tuple[Scene, None]:
    """The cubes one above the other, each a little above and turned."""
    material = Material(
        young_modulus=values["young_modulus"], poisson_ratio=0.4, stiffness_damping=0.02
    )
    cubes = [_cube(level, material, values["height"]) for level in range(int(values["count"]))]
    scene = Scene(
        character=cubes[0],
        others=tuple(Body(character=cube) for cube in cubes[1:]),
        ground=Plane(friction=values["friction"]),
        body_friction=values["friction"],
    )
    return scene, None


def _cube(level: int, material: Material, height: float) -> Character:
    # meshes that differ, so that no node stands on another
    mesh = box_mesh((3 + level % 2,) * 3, (SIDE,) * 3, (-0.5 * SIDE, -0.5 * SIDE, 0.0))
    cube = Character(
        name=f"cube_{level}", mesh=mesh, material=material, color=COLORS[level % len(COLORS)]
    )
    place = (0.0, 0.0, level * (SIDE + height))
    return placed(cube, translation=place, degrees=TURN * level)


RECIPE = SceneRecipe(
    name="stack",
    description="soft cubes dropped on each other come to rest as a stack",
    settings=(
        Setting(name="count", whole=True, default=3, low=2, high=8, unit="cubes", help="how many"),
        Setting(name="height", default=0.05, low=0.0, high=2.0, unit="m", help="of each drop"),
        Setting(name="friction", default=0.5, low=0.0, high=1e3, help="Coulomb coefficient of all"),
        Setting(
            name="young_modulus", default=3e5, low=1e3, high=1e9, unit="Pa", help="of the cubes"
        ),
    ),
    build=build,
    seconds=3.0,
    time_step=0.01,
)
