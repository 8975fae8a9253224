"""What counts as zero in contact with the ground: impulses and speeds, in proportion to bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.engine.material_parts import MaterialPart
from warp_softbody.engine.rest_matrix import rest_gradients
from warp_softbody.world.scene import Scene

SLOWEST_SLIDING = 1e-8
"""Speed, m/s, below which nothing slides, however stiff."""

STILL = 1e-5
"""Speed, m/s, off the ground or along it, that counts as none."""

EARTH = 9.81
"""Gravity, m/s^2, with which a body of a metre moves at the speeds that tolerances are made for."""


@dataclass(frozen=True, kw_only=True)
class ContactTolerances:
    """What counts as zero in contact with the ground.

    Attributes:
        impulse: N s.
        normal_speed: m/s, off the ground.
        sliding_speed: m/s, along the ground.
    """

    impulse: float
    normal_speed: float
    sliding_speed: float


def speed_share(scene: Scene) -> float:
    """Speeds of a scene's smallest body, sqrt(g size), of those of a metre on Earth; at most 1."""
    sizes = [np.linalg.norm(np.ptp(c.mesh.points, axis=0)) for c in scene.characters]
    gravity = float(np.linalg.norm(scene.gravity)) or EARTH
    return float(min(1.0, np.sqrt(gravity * min(sizes) / EARTH)))


def contact_tolerances(
    scene: Scene, dt: float, masses: FloatArray, materials: tuple[MaterialPart, ...]
) -> ContactTolerances:
    """The tolerances of a scene with a time step ``dt``, s, and nodes of masses (n,) kg."""
    # a millionth of the weight's impulse, and 0.01 mm/s off what is touched for bodies of a metre
    weight = float(masses.sum()) * float(np.linalg.norm(scene.gravity))
    impulse = 1e-6 * weight * dt
    # along it, the speed that a node's own block answers with twenty of these impulses: a stiff
    # body's friction changes much while its nodes hardly move
    share = speed_share(scene)
    still = speed = STILL * share
    if weight > 0.0:
        largest = _largest_block(scene, masses, materials)
        speed = min(speed, max(SLOWEST_SLIDING * share, 20.0 * impulse / largest))
    return ContactTolerances(impulse=impulse, normal_speed=still, sliding_speed=speed)


def _largest_block(scene: Scene, masses: FloatArray, materials: tuple[MaterialPart, ...]) -> float:
    """Largest third of the trace of a surface node's block of M~ at rest, kg."""
    mesh, volumes = scene.whole.mesh, scene.elastic_volumes
    squares = (rest_gradients(mesh) ** 2).sum(axis=2)
    blocks = np.zeros(len(masses))
    for part in materials:
        # K_aa = V ((mu |g|^2) I + (mu + lambda) g g^T)
        modulus = 4.0 * part.material.lame_mu + part.material.lame_lambda
        shares = (part.stiffness_factor * modulus / 3.0) * volumes[part.tets]
        np.add.at(blocks, mesh.tets[part.tets], shares[:, None] * squares[part.tets])
        blocks[part.nodes] += part.mass_factor * masses[part.nodes]
    return float(blocks[mesh.surface_nodes].max())
