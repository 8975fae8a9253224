"""Bodies that touch each other, their run and their energy."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tests.support.bodies import box
from warp_softbody import Material, Scene, Simulation, SimulationOptions, TetMesh
from warp_softbody.body.character import Character
from warp_softbody.world.joined_bodies import placed

SIDE = 0.3
SOFT = Material(young_modulus=1e5, poisson_ratio=0.4, stiffness_damping=0.02)
GRAVITY = 9.81


def cube(
    name: str = "cube",
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
    cells: int = 3,
    degrees: float = 0.0,
    material: Material = SOFT,
) -> Character:
    """A cube whose lowest face is centred at a place."""
    mesh = box((cells,) * 3, (SIDE,) * 3, (-SIDE / 2, -SIDE / 2, 0.0))
    body = Character(name=name, mesh=mesh, material=material)
    return placed(body, translation=at, degrees=degrees)


def slab() -> Character:
    """A floor that cannot move."""
    mesh = box((3, 3, 1), (3.0, 3.0, 0.3), (-1.5, -1.5, -0.3))
    return Character(name="slab", mesh=mesh, fixed=np.arange(len(mesh.points), dtype=np.int32))


def simulate(scene: Scene, seconds: float, **options: Any) -> Simulation:
    step = options.setdefault("time_step", 0.01)
    simulation = Simulation(scene, options=SimulationOptions(**options), fps=1.0 / step)
    for _ in range(round(seconds / step)):
        simulation.step()
    return simulation


def energy(simulation: Simulation) -> float:
    """Kinetic and elastic energy of all bodies, J (docs/method.md section 1)."""
    model = simulation.model
    speeds = simulation.state.velocities.numpy().astype(np.float64)
    points = simulation.state.positions.numpy().astype(np.float64)
    total = 0.5 * float(model.masses @ (speeds**2).sum(axis=1))
    for part in model.scene.parts:
        mesh = model.body.mesh
        tets = mesh.tets[part.tets]
        rest, now = (
            (p[tets[:, 1:]] - p[tets[:, :1]]).transpose(0, 2, 1) for p in (mesh.points, points)
        )
        left, stretch, right = np.linalg.svd(now @ np.linalg.inv(rest))
        stretch[:, 2] *= np.linalg.det(left @ right)
        mu, lam = part.material.lame_mu, part.material.lame_lambda
        strain = stretch - 1.0
        density = mu * (strain**2).sum(axis=1) + 0.5 * lam * strain.sum(axis=1) ** 2
        total += float(mesh.volumes[part.tets] @ density)
    return total


def hairpin() -> Character:
    """Two arms of 0.6 x 0.1 x 0.06 m, 0.06 m apart, joined at one end; the lower one is fixed."""
    mesh = box((10, 2, 6), (0.6, 0.1, 0.18))
    centres = mesh.points[mesh.tets].mean(axis=1)
    gap = (abs(centres[:, 2] - 0.09) < 0.03) & (centres[:, 0] > 0.06)
    kept = TetMesh.from_arrays(mesh.points, mesh.tets[~gap])
    x, _, z = kept.points.T
    lower = np.flatnonzero((z < 1e-9) & (x > 0.3)).astype(np.int32)
    tip = np.flatnonzero((z > 0.18 - 1e-9) & (x > 0.6 - 1e-9)).astype(np.int32)
    return Character(
        name="hairpin",
        mesh=kept,
        material=replace(SOFT, poisson_ratio=0.3),
        fixed=lower,
        regions={"tip": tip},
    )
