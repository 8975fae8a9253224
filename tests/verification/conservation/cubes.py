"""Cubes of 0.2 m in free space, on their way to each other."""

from __future__ import annotations

import numpy as np

from tests.support.bodies import box, turned
from warp_softbody import Body, Character, Material, Scene, TetMesh, placed

NO_GRAVITY = (0.0, 0.0, 0.0)


def cube(name: str, cells: int, degrees: float, young_modulus: float = 1e6) -> Character:
    """A cube of 0.2 m about the origin, turned about an oblique axis."""
    mesh = box((cells,) * 3, (0.2, 0.2, 0.2), (-0.1, -0.1, -0.1))
    points = turned(mesh.points, (1.0, 2.0, 0.5), np.radians(degrees))
    material = Material(young_modulus=young_modulus, poisson_ratio=0.3, stiffness_damping=0.01)
    return Character(name=name, mesh=TetMesh.from_arrays(points, mesh.tets), material=material)


def colliding(count: int, speed: float, young_modulus: float) -> Scene:
    """Bodies on their way to the origin from all around, the first from -x."""
    ways = np.array([[-1, 0, 0], [1, 0.1, 0.05], [0.1, -1.2, 0], [0, 1.3, 0.1], [0.05, 0, 1.2]])
    bodies = []
    for k in range(count):
        character = cube(f"cube_{k}", 2 + k % 3, 15.0 * k, young_modulus)
        where = placed(character, translation=tuple(0.25 * ways[k]))
        bodies.append((where, tuple((-speed * ways[k] / np.linalg.norm(ways[k])).tolist())))
    others = tuple(Body(character=body, velocity=velocity) for body, velocity in bodies[1:])
    return Scene(
        character=bodies[0][0],
        others=others,
        gravity=NO_GRAVITY,
        initial_velocity=bodies[0][1],
        body_friction=0.4,
    )
