"""A bar, clamped at one end, is wrung along its sides, let go, and swings back."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.scenes.drop_block import box_mesh
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.world.scene import Push, Scene

LENGTH, SIDE = 1.0, 0.2  # m, along x and across
MATERIAL = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.005)
SIDES = {
    "top": (2, 1.0, (0.0, -1.0, 0.0)),
    "bottom": (2, -1.0, (0.0, 1.0, 0.0)),
    "right": (1, 1.0, (0.0, 0.0, 1.0)),
    "left": (1, -1.0, (0.0, 0.0, -1.0)),
}
"""Axis across the side, its sign, and where forces on it point: together a couple about +x."""


def build(values: Values) -> tuple[Scene, None]:
    """The bar around the x axis, its face at x = 0 held; no weight.

    Each side carries the same force, spread evenly along it and tangential, so that the torque is
    the same on every mesh: four forces at the arm of half a side.
    """
    across = int(values["cells"])
    half = SIDE / 2.0
    mesh = box_mesh((5 * across, across, across), (LENGTH, SIDE, SIDE), (0.0, -half, -half))
    regions = {
        name: np.flatnonzero(sign * mesh.points[:, axis] > half - 1e-9).astype(np.int32)
        for name, (axis, sign, _) in SIDES.items()
    }
    along = mesh.points[:, 0]
    regions["end"] = np.flatnonzero(along > LENGTH - 1e-9).astype(np.int32)
    bar = Character(
        name="bar",
        mesh=mesh,
        material=MATERIAL,
        regions=regions,
        fixed=np.flatnonzero(along < 1e-9).astype(np.int32),
    )
    force = values["torque"] / (4.0 * half)
    pushes = tuple(
        Push(
            region=name,
            force=(force * way[0], force * way[1], force * way[2]),
            start=0.0,
            duration=values["hold"],
        )
        for name, (_, _, way) in SIDES.items()
    )
    return Scene(character=bar, gravity=(0.0, 0.0, 0.0), pushes=pushes), None


RECIPE = SceneRecipe(
    name="twisted-bar",
    description="a clamped bar is twisted, let go, and swings back",
    settings=(
        Setting(
            name="torque",
            default=10.0,
            low=0.0,
            high=1e3,
            unit="N m",
            help="along all of its length",
        ),
        Setting(name="hold", default=0.4, low=0.0, high=1e3, unit="s", help="until it is let go"),
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
