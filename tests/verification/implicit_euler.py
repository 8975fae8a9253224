"""The implicit Euler equation of a step, in NumPy: what its velocities leave of it."""

from __future__ import annotations

import numpy as np

from tests.support.bodies import EXACT, Rig, epsilon, numbers
from tests.verification import reference
from tests.verification.accuracy import damping_forces
from tests.verification.smoothed_reference import smoothed_forces
from tests.verification.volume_reference import volume_forces
from warp_softbody.arrays import FloatArray


def elastic_forces(body: Rig, points: FloatArray) -> FloatArray:
    """Of the body's elements at some positions, (n, 3) N."""
    character = body.model.scene.character
    formula = reference.elastic_forces
    if body.model.options.elements == "smoothed":
        formula = smoothed_forces
    elif character.material.volume == "exact":
        formula = volume_forces
    return formula(character.mesh, character.material, points)


def residual(body: Rig, others: FloatArray | float = 0.0) -> FloatArray:
    """``M v+ - M v - dt (forces at x+ and v+) - dt others`` of the last step, (n, 3) kg m/s.

    Zero at fixed nodes; stiffness damping is by the K of the body's tangent at x+.
    """
    scene, options = body.model.scene, body.model.options
    mesh, material = scene.character.mesh, scene.character.material
    x, v, masses = body.positions, body.velocities, body.masses[:, None]
    force = elastic_forces(body, x) + numbers(body.control.external_forces) + others
    force += masses * (np.array(scene.gravity) - material.mass_damping * v)
    if material.stiffness_damping > 0.0:
        force += damping_forces(mesh, material, options.tangent, x, v)
    gap = masses * (v - numbers(body.after.velocities)) - options.time_step * force
    gap[body.model.fixed] = 0.0
    return np.asarray(gap)


def step_matrix(body: Rig) -> FloatArray:
    """The engine's M~ at the state after the step, (3n, 3n)."""
    body.stepper.assemble(body.state)
    return reference.block_matrix(body.model, numbers(body.stepper.assembly.values))


def rounding(body: Rig, share: float = 0.0) -> float:
    """Of the residual's norm: the solve's tolerance, eps and another share of the sums in M~ v."""
    sums = np.abs(step_matrix(body)) @ np.abs(body.velocities).ravel()
    share += EXACT["tolerance"] + 32.0 * epsilon("float64")
    return float(share * np.linalg.norm(sums))
