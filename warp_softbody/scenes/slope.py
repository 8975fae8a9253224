"""A slab on a slope: it stays below the friction angle and slides above it."""

from __future__ import annotations

import math

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.scenes.drop_block import box_mesh
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

MATERIAL = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.02)


def build(values: Values) -> tuple[Scene, None]:
    """The slab at rest on a plane that falls towards +x."""
    angle = math.radians(values["slope_degrees"])
    through = int(values["cells"])
    flat = box_mesh((3 * through, 3 * through, through), (0.3, 0.3, 0.08), (-0.15, -0.15, 0.0))
    cosine, sine = math.cos(angle), math.sin(angle)
    lean = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])
    mesh = TetMesh.from_arrays(flat.points @ lean.T, flat.tets)
    scene = Scene(
        character=Character(name="slab", mesh=mesh, material=MATERIAL),
        ground=Plane(friction=values["friction"], normal=(sine, 0.0, cosine)),
    )
    return scene, None


RECIPE = SceneRecipe(
    name="slope",
    description="a slab on a slope stays or slides, as friction says",
    settings=(
        Setting(
            name="slope_degrees", default=30.0, low=0.0, high=80.0, unit="degrees", help="of fall"
        ),
        Setting(
            name="friction", default=0.5, low=0.0, high=1e3, help="Coulomb coefficient of the slope"
        ),
        Setting(
            name="cells",
            whole=True,
            default=2,
            low=1,
            high=16,
            help="of the mesh through it; three times along",
        ),
    ),
    build=build,
    seconds=2.0,
    time_step=0.01,
)
