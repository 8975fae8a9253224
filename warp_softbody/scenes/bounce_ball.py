"""A soft ball is dropped and bounces."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.stairs import ball_mesh
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

RADIUS = 0.15  # m
SHELLS = 3
BALL = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.002)


def build(values: Values) -> tuple[Scene, None]:
    """The ball at rest above a floor."""
    center = np.array([0.0, 0.0, RADIUS + values["height"]])
    mesh = ball_mesh(RADIUS, center, refinements=int(values["cells"]), shells=SHELLS)
    scene = Scene(
        character=Character(name="ball", mesh=mesh, material=BALL),
        ground=Plane(friction=0.5),
    )
    return scene, None


RECIPE = SceneRecipe(
    name="bounce-ball",
    description="a soft ball is dropped and bounces",
    settings=(
        Setting(name="height", default=0.3, low=0.0, high=5.0, unit="m", help="of the drop"),
        Setting(
            name="cells",
            whole=True,
            default=2,
            low=0,
            high=3,
            help="how often the faces of an icosahedron are cut in four",
        ),
    ),
    build=build,
    seconds=2.0,
    time_step=1.0 / 120.0,
)
