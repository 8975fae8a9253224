"""A beam, clamped at one end, falls under its weight and swings."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.scenes.drop_block import box_mesh
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.world.scene import Scene

SIZE = (1.0, 0.2, 0.2)  # m


def build(values: Values) -> tuple[Scene, None]:
    """The beam at rest, straight along x, its face at x = 0 held; nothing damps it."""
    across = int(values["cells"])
    mesh = box_mesh((5 * across, across, across), SIZE, (0.0, 0.0, 0.0))
    along = mesh.points[:, 0]
    material = Material(
        young_modulus=values["young_modulus"],
        poisson_ratio=values["poisson_ratio"],
        stiffness_damping=0.0,
    )
    beam = Character(
        name="beam",
        mesh=mesh,
        material=material,
        regions={"tip": np.flatnonzero(along > SIZE[0] - 1e-9).astype(np.int32)},
        fixed=np.flatnonzero(along < 1e-9).astype(np.int32),
    )
    return Scene(character=beam), None


RECIPE = SceneRecipe(
    name="cantilever",
    description="a clamped beam falls under its weight and swings",
    settings=(
        Setting(name="young_modulus", default=1e6, low=1e3, high=1e12, unit="Pa", help="of it"),
        Setting(name="poisson_ratio", default=0.4, low=0.0, high=0.49, help="of it"),
        Setting(
            name="cells",
            whole=True,
            default=3,
            low=1,
            high=24,
            help="of the mesh across; five times along",
        ),
    ),
    build=build,
    seconds=2.0,
    time_step=0.01,
)
