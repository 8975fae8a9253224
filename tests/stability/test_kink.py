"""Why a kinked bar does not recover: it stands in a minimum of the energy."""

from __future__ import annotations

import numpy as np

from benchmarks.stability.bodies import bar_mesh, body
from benchmarks.stability.starts import kinked
from tests.support.bodies import rig
from tests.verification import reference

LENGTH = 1e-6
"""Of the shifts that the Hessian is differenced over, m."""


def test_a_half_turn_in_one_layer_is_a_minimum_of_the_energy() -> None:
    character = body(bar_mesh())
    mesh, material = character.mesh, character.material
    bar = rig(character, time_step=0.01, precision="float64")
    bar.place(kinked((1.0, 1.0, 1.0))(character).positions)
    bar.step(1000)
    unknowns = np.setdiff1d(
        np.arange(mesh.points.size), 3 * character.fixed[:, None] + np.arange(3)
    )

    def forces(shift: float, unknown: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        shifted = bar.positions.ravel()
        shifted[unknown] += shift
        pull = reference.elastic_forces(mesh, material, shifted.reshape(-1, 3))
        return np.asarray(pull.ravel()[unknowns])

    columns = [(forces(-LENGTH, u) - forces(LENGTH, u)) / (2.0 * LENGTH) for u in unknowns]
    lowest = np.linalg.eigvalsh(np.stack(columns, axis=1))[0]
    # truncation by a third derivative, of the order of stiffness over edge length, times LENGTH^2
    # and rounding, eps times force over LENGTH, are a millionth of this and less
    assert lowest > 1.0
    # where a Newton step is below a ten-thousandth of a cell, and the energy far above that at rest
    assert np.linalg.norm(forces(0.0, 0)) / lowest < 1e-5
    assert reference.elastic_energy(mesh, material, bar.positions) > 1000.0
