"""A heavy mat falls on uneven ground and comes to lie on it with hundreds of contacts."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.scenes.drop_block import box_mesh
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.world.height_field import HeightField
from warp_softbody.world.scene import Scene

SIDE, THICKNESS = 1.0, 0.05  # m
CELLS = (24, 24, 2)
EXTENT, POINTS = 3.0, 61
DROP = 0.05  # m, above the highest point
MATERIAL = Material(young_modulus=5e4, poisson_ratio=0.35, density=1500.0, stiffness_damping=0.02)


def hills(roughness: float, friction: float) -> HeightField:
    """Waves of a few directions and lengths; `roughness` is the largest height, m."""
    x, y = np.meshgrid(*[np.linspace(-EXTENT / 2, EXTENT / 2, POINTS)] * 2, indexing="ij")
    waves = np.sin(7.0 * x + 2.0 * y) + np.sin(5.0 * y - 3.0 * x + 1.0)
    waves += 0.5 * np.sin(13.0 * x - 4.0 * y + 2.0) + 0.5 * np.sin(11.0 * y + 6.0 * x)
    step = EXTENT / (POINTS - 1)
    return HeightField(
        heights=roughness * waves / np.abs(waves).max(),
        spacing=(step, step),
        origin=(-EXTENT / 2, -EXTENT / 2),
        friction=friction,
    )


def build(values: Values) -> tuple[Scene, None]:
    """The mat, level, over the hills."""
    lowest = values["roughness"] + DROP
    mesh = box_mesh(CELLS, (SIDE, SIDE, THICKNESS), (-SIDE / 2, -SIDE / 2, lowest))
    scene = Scene(
        character=Character(name="mat", mesh=mesh, material=MATERIAL),
        ground=hills(values["roughness"], values["friction"]),
    )
    return scene, None


RECIPE = SceneRecipe(
    name="rough-ground",
    description="a heavy mat falls on uneven ground",
    settings=(
        Setting(
            name="roughness", default=0.04, low=0.0, high=0.3, unit="m", help="of the highest hill"
        ),
        Setting(
            name="friction",
            default=0.8,
            low=0.0,
            high=1e3,
            help="Coulomb coefficient of the ground",
        ),
    ),
    build=build,
    seconds=2.0,
    time_step=0.01,
)
