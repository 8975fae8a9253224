"""A cube above a level floor, and its energy."""

from __future__ import annotations

from typing import Any

from tests.support.bodies import Rig, box, rig
from tests.verification.reference import elastic_energy
from warp_softbody.body.material import Material
from warp_softbody.world.ground import Plane

G = 9.81
SIDE = 0.3


def cube(
    height: float,
    young_modulus: float,
    damping: float,
    dt: float,
    *,
    cells: int = 4,
    friction: float = 0.5,
    **options: Any,
) -> Rig:
    mesh = box((cells,) * 3, (SIDE,) * 3, (-SIDE / 2, -SIDE / 2, height))
    material = Material(young_modulus=young_modulus, poisson_ratio=0.4, stiffness_damping=damping)
    return rig(
        mesh,
        material=material,
        ground=Plane(friction=friction),
        gravity=(0.0, 0.0, -G),
        time_step=dt,
        **options,
    )


def energy(body: Rig) -> float:
    """Kinetic, potential and elastic energy, J."""
    character = body.model.scene.character
    moving = 0.5 * (body.velocities**2).sum(axis=1) + G * body.positions[:, 2]
    return elastic_energy(character.mesh, character.material, body.positions) + float(
        body.masses @ moving
    )
