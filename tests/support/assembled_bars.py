"""A muscular bar whose matrix is assembled, and rows of J for it."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.support.bodies import EXACT, Rig, crumpled, muscular_bar, rig
from tests.verification import reference
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material

DT = 0.01
MATERIAL = Material(young_modulus=2e5, poisson_ratio=0.4, stiffness_damping=0.01, mass_damping=0.5)


def stretched(fixed: Any = (), **options: Any) -> tuple[Rig, FloatArray]:
    """A crumpled bar in flight with straight and winding fibres, and its matrix."""
    bar = muscular_bar(MATERIAL, helix=True)
    character = Character(
        name="bar",
        mesh=bar.mesh,
        material=MATERIAL,
        muscles=bar.muscles,
        regions=bar.regions,
        fixed=np.asarray(fixed, dtype=np.int32),
    )
    body = rig(character, gravity=(0.0, 0.0, -9.81), time_step=DT, **(EXACT | options))
    positions = crumpled(bar.mesh, amount=0.05)
    velocities = np.random.default_rng(4).standard_normal(positions.shape)
    velocities[list(fixed)] = 0.0
    body.place(positions, velocities)
    body.stepper.assemble(body.state)
    matrix = reference.step_matrix(body.model, body.positions)
    held = (3 * np.asarray(fixed, dtype=int)[:, None] + np.arange(3)).ravel()
    matrix[held] = 0.0
    matrix[:, held] = 0.0
    matrix[held, held] = 1.0
    return body, matrix


def some_rows(body: Rig, count: int, seed: int = 0) -> FloatArray:
    """Random rows, the three momenta among them."""
    rows = np.random.default_rng(seed).standard_normal((count, 3 * body.model.node_count))
    for axis in range(min(3, count)):
        rows[2 * axis] = 0.0
        rows[2 * axis, axis::3] = body.masses
    return rows
