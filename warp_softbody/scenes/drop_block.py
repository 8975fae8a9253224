"""A soft cube is dropped while it moves sideways, slides and comes to rest."""

from __future__ import annotations

import itertools

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.world.ground import Plane, Vector
from warp_softbody.world.scene import Scene

SIDE = 0.3  # m


def box_mesh(cells: tuple[int, int, int], size: Vector, origin: Vector) -> TetMesh:
    """A grid of cells of six tets each, all diagonals one way; `origin` is the lowest corner."""
    ticks = [np.linspace(0.0, s, c + 1) for s, c in zip(size, cells, strict=True)]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 3)
    shape = tuple(count + 1 for count in cells)
    tets = []
    for axes in itertools.permutations(range(3)):
        steps = np.zeros((4, 3), dtype=int)
        for count, axis in enumerate(axes):
            steps[count + 1 :, axis] += 1
        tets.append(np.ravel_multi_index(tuple(np.moveaxis(corner[:, None] + steps, -1, 0)), shape))
    return TetMesh.from_arrays(points + np.asarray(origin), np.concatenate(tets))


def build(values: Values) -> tuple[Scene, None]:
    """The cube over a floor, in flight."""
    half = SIDE / 2.0
    mesh = box_mesh((int(values["cells"]),) * 3, (SIDE,) * 3, (-half, -half, values["height"]))
    material = Material(
        young_modulus=values["young_modulus"], poisson_ratio=0.4, stiffness_damping=0.02
    )
    scene = Scene(
        character=Character(name="cube", mesh=mesh, material=material),
        ground=Plane(friction=values["friction"]),
        initial_velocity=(values["speed"], 0.0, 0.0),
    )
    return scene, None


RECIPE = SceneRecipe(
    name="drop-block",
    description="a soft cube is dropped while it moves sideways and slides to rest",
    settings=(
        Setting(name="height", default=0.05, low=0.0, high=5.0, unit="m", help="of the drop"),
        Setting(name="speed", default=1.0, low=-10.0, high=10.0, unit="m/s", help="sideways, +x"),
        Setting(
            name="friction", default=0.5, low=0.0, high=1e3, help="Coulomb coefficient of the floor"
        ),
        Setting(
            name="young_modulus", default=1e5, low=1e3, high=1e9, unit="Pa", help="of the cube"
        ),
        Setting(
            name="cells", whole=True, default=7, low=1, high=24, help="of the mesh along each side"
        ),
    ),
    build=build,
    seconds=2.0,
    time_step=0.01,
)
