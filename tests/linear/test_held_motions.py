"""What the coarse level knows of contact, against dense NumPy and by the iterations it saves."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.linear.dense_two_level import MESH, TWO_LEVEL, dense_two_level, level_of, rigid_motions
from tests.linear.matrices import assembled, cut, factor_of, preconditioned
from tests.support.bodies import box
from warp_softbody import Character, Material, Plane, Scene, SimulationOptions, Stepper, build_model
from warp_softbody.engine.model import Model
from warp_softbody.engine.state import Contacts, Control, State
from warp_softbody.kernels.linear.codes import VelocityConstraint

HELD = (0, 19, 37, 55, 79)
"""As many nodes as there are groups, so that each resists by itself."""


def dropped(cells: int, young_modulus: float = 1e5, **options: Any) -> Model:
    """A cube of 0.3 m that moves sideways and down, on a plane with friction."""
    material = Material(young_modulus=young_modulus, poisson_ratio=0.4, stiffness_damping=0.02)
    body = Character(name="cube", mesh=box((cells,) * 3, (0.3,) * 3), material=material)
    scene = Scene(
        character=body,
        ground=Plane(friction=0.5),
        gravity=(0.0, 0.0, -9.81),
        initial_velocity=(1.0, 0.0, -1.0),
    )
    return build_model(scene, SimulationOptions(time_step=0.01, **TWO_LEVEL, **options))


def iterations_of(model: Model, steps: int = 25) -> int:
    """Iterations of all steps, each of which settles."""
    stepper, contacts, control = Stepper(model), Contacts.none(model), Control.slack(model)
    states = [State.at_rest(model), State.at_rest(model)]
    total = 0
    for _ in range(steps):
        statistics = stepper.step(states[0], control, contacts, states[1])
        states.reverse()
        assert statistics.converged and statistics.contact_converged
        total += statistics.iterations
    return total


def untold(model: Model) -> Model:
    """The same, its coarse level that of a body that nothing touches."""
    coarse = model.system.coarse
    assert coarse is not None and coarse.held_margin is not None
    return replace(model, system=replace(model.system, coarse=replace(coarse, held_margin=None)))


def test_held_nodes_resist_the_motions_of_their_aggregates() -> None:
    body, matrix = assembled(MESH, ground=Plane(friction=0.5), precision="float64", **TWO_LEVEL)
    n = len(MESH.points)
    kinds = np.full(n, VelocityConstraint.NONE)
    kinds[list(HELD)] = VelocityConstraint.FIXED
    held = (3 * np.asarray(HELD)[:, None] + np.arange(3)).ravel()
    own = matrix[held, held].reshape(-1, 3).mean(axis=1)
    motions = rigid_motions(body)
    resisted = (motions[held] * np.repeat(own, 3)[:, None]).T @ motions[held]
    free = np.eye(3 * n)
    free[held] = 0.0
    found = preconditioned(body, factor_of(body, kinds), free)
    expected = free @ dense_two_level(body, cut(matrix, HELD), resisted, free) @ free
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize(("young_modulus", "share"), [(1e5, 0.85), (1e7, 0.5)])
def test_it_saves_iterations_in_contact(young_modulus: float, share: float) -> None:
    model = dropped(8, young_modulus)
    assert iterations_of(model) <= share * iterations_of(untold(model))


def test_iterations_in_contact_hardly_grow_with_the_mesh() -> None:
    """Less than with the root of the cells along a side."""
    assert iterations_of(dropped(14)) <= 2.0**0.75 * iterations_of(dropped(7))


def test_a_body_that_touches_nothing_or_is_too_stiff_is_told_nothing() -> None:
    body, _ = assembled(MESH, **TWO_LEVEL)
    assert level_of(body).held_margin is None
    stiff = dropped(3, 1e10, precision="float32").system.coarse
    assert stiff is not None and stiff.held_margin is None
