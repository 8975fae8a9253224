"""A slab whose base slides differently each way, on a level floor."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tests.support.bodies import Rig, box, rig, turned
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.body.material import Material
from warp_softbody.body.mesh import TetMesh
from warp_softbody.world.ground import Plane

G = 9.81
DT = 0.01
EIGHT = (0.5, 0.7, 1.0, 1.5, 3.0, 2.0, 1.2, 0.8)
BASE = 0.2
STIFF = Material(young_modulus=1e6, poisson_ratio=0.3, stiffness_damping=0.02)


def scaly_slab(
    factors: tuple[float, ...] = EIGHT,
    turn: float = 0.0,
    direction: FloatArray | None = None,
    **options: Any,
) -> Rig:
    """A flat slab on a floor, turned about z; its base slides differently each way."""
    flat = box((3, 3, 1), (0.3, 0.3, 0.06), (-0.15, -0.15, 0.0))
    mesh = TetMesh.from_arrays(turned(flat.points, (0.0, 0.0, 1.0), turn), flat.tets)
    ahead = np.array([math.cos(turn), math.sin(turn), 0.0]) if direction is None else direction
    friction = DirectionalFriction(
        region="base", direction=(ahead[0], ahead[1], ahead[2]), factors=factors
    )
    base = np.flatnonzero(mesh.points[:, 2] < 1e-9).astype(np.int32)
    character = Character(
        name="slab",
        mesh=mesh,
        material=STIFF,
        regions={"base": base},
        directional_friction=(friction,),
    )
    options = {"time_step": DT} | options
    return rig(character, ground=Plane(friction=BASE), gravity=(0.0, 0.0, -G), **options)
