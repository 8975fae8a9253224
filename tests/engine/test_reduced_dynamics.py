"""The maps of the reduced dynamics against dense solves and against the step itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.assembled_bars import DT, some_rows, stretched
from tests.support.bodies import Rig, exact_dynamics
from tests.verification import reference
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import Precision
from warp_softbody.engine.reduced_dynamics import ReducedDynamics
from warp_softbody.errors import InputError


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize(("count", "fixed"), [(7, ()), (40, (0, 1, 5, 40))])
def test_native_code_of_processors_does_what_the_plain_kernels_do(
    count: int, fixed: tuple[int, ...], precision: Precision
) -> None:
    """To a few roundings; where the compiler fuses no operations, to the last bit."""
    found = []
    for native in (True, False):
        body, _ = stretched(fixed, precision=precision, native_code=native)
        problem = ReducedDynamics(body.stepper, tolerance=1e-5).solve(some_rows(body, count))
        found.append((problem.responses, problem.free_velocity, problem.muscle_map))
        assert problem.converged and problem.iterations > 0
    for native, expected in zip(*found, strict=True):
        bound = 64 * float(np.finfo(precision).eps) * np.abs(expected).max()
        np.testing.assert_allclose(native, expected, rtol=0.0, atol=bound)


@pytest.mark.parametrize("fixed", [(), (0, 1, 5, 40)])
@pytest.mark.parametrize("count", [7, 16, 40])
def test_responses_equal_a_dense_solve(fixed: Any, count: int) -> None:
    """Momenta included, which are answered in closed form where no node is fixed."""
    body, matrix = stretched(fixed)
    rows = some_rows(body, count)
    problem = exact_dynamics(body, row_capacity=count).solve(rows)
    right = rows.T.copy()
    right[(3 * np.asarray(fixed, dtype=int)[:, None] + np.arange(3)).ravel()] = 0.0
    expected = np.linalg.solve(matrix, right).T
    scale = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(problem.responses / scale, expected / scale, atol=1e-9)
    np.testing.assert_array_equal(problem.compliance, problem.compliance.T)
    assert (np.linalg.eigvalsh(problem.compliance) > 0.0).all()
    expected = rows @ expected.T
    bound = 1e-9 * np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert (np.abs(problem.compliance - expected) <= bound).all()


def test_momenta_are_answered_in_closed_form() -> None:
    """D / (1 + dt mu) at every node, without an iteration."""
    body, _ = stretched()
    rows = np.zeros((3, body.model.node_count, 3))
    for axis in range(3):
        rows[axis, :, axis] = 2.5 * body.masses
    problem = exact_dynamics(body).solve(rows.reshape(3, -1))
    assert problem.iterations == 0
    expected = np.tile(2.5 * np.eye(3), body.model.node_count) / (1.0 + DT * 0.5)
    np.testing.assert_allclose(problem.responses, expected, rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(problem.muscle_map, 0.0)


def velocities_after(body: Rig, rest_lengths: FloatArray) -> FloatArray:
    """v+ (3n,) of one step from the state as it is."""
    body.control.rest_lengths.assign(rest_lengths)
    body.stepper.step(body.state, body.control, body.contacts, body.after)
    return np.asarray(body.after.velocities.numpy(), dtype=np.float64).ravel()


@pytest.mark.parametrize("fixed", [(), (0, 1, 5, 40)])
def test_free_velocity_is_the_slack_step_s(fixed: Any) -> None:
    body, _ = stretched(fixed)
    rows = some_rows(body, 20)
    problem = exact_dynamics(body, row_capacity=20).solve(rows, free=True)
    expected = rows @ velocities_after(body, 1e6 * problem.rest_lengths)
    scale = np.abs(rows) @ np.abs(body.velocities).ravel()
    np.testing.assert_allclose(problem.free_velocity / scale, expected / scale, atol=1e-10)


@pytest.mark.parametrize("fixed", [(), (0, 1, 5, 40)])
def test_muscle_map_is_the_derivative_of_the_step(fixed: Any) -> None:
    """v+ is linear in l_d below l, so central differences of any width are exact."""
    body, _ = stretched(fixed)
    rows = some_rows(body, 20)
    problem = exact_dynamics(body, row_capacity=20).solve(rows, free=True)
    base = 0.9 * problem.lengths
    differences = np.zeros_like(problem.muscle_map)
    for segment in range(len(base)):
        width = 0.05 * problem.lengths[segment]
        ends = []
        for sign in (1.0, -1.0):
            moved = base.copy()
            moved[segment] += sign * width
            ends.append(rows @ velocities_after(body, moved))
        differences[:, segment] = (ends[0] - ends[1]) / (2.0 * width)
    bound = 1e-8 * np.abs(problem.muscle_map).max(axis=1, keepdims=True) + 1e-9
    assert (np.abs(differences - problem.muscle_map) <= bound).all()
    whole = problem.free_velocity + problem.muscle_map @ (base - problem.lengths)
    scale = np.abs(rows) @ np.abs(body.velocities).ravel()
    np.testing.assert_allclose(
        whole / scale, rows @ velocities_after(body, base) / scale, atol=1e-9
    )


def test_lengths_are_those_of_the_moved_fibres() -> None:
    body, _ = stretched()
    problem = exact_dynamics(body).solve(some_rows(body, 7))
    expected = reference.segment_lengths(body.model.scene.character, body.positions)
    np.testing.assert_allclose(problem.lengths, expected, rtol=1e-12)
    np.testing.assert_allclose(problem.rest_lengths[:12], 0.58 / 6, rtol=1e-12)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_default_tolerance_is_kept(precision: Precision) -> None:
    """|J^T - M~ W| <= 1e-3 |J^T|, column by column, when warm and when rows change."""
    body, matrix = stretched(precision=precision)
    dynamics = ReducedDynamics(body.stepper, row_capacity=32)
    for seed, count in ((0, 20), (1, 20), (2, 9), (3, 32), (4, 20)):
        rows = some_rows(body, count, seed)
        problem = dynamics.solve(rows)
        left = rows - problem.responses @ matrix
        share = np.linalg.norm(left, axis=1) / np.linalg.norm(rows, axis=1)
        # the reference matrix and the residual itself are rounded in float32
        assert share.max() <= 1.2e-3


def test_warm_start_saves_the_iterations() -> None:
    body, _ = stretched()
    dynamics = exact_dynamics(body, row_capacity=20)
    rows = some_rows(body, 20)
    assert dynamics.solve(rows).iterations > 0
    assert dynamics.solve(rows).iterations == 0


def test_it_makes_room_for_more_rows() -> None:
    body, matrix = stretched()
    dynamics = exact_dynamics(body, row_capacity=16)
    rows = some_rows(body, 40)
    for count in (5, 40, 5):
        problem = dynamics.solve(rows[:count])
        left = rows[:count] - problem.responses @ matrix
        assert np.linalg.norm(left) <= 1e-9 * np.linalg.norm(rows[:count])
    assert dynamics.row_capacity >= 40


def test_fewer_rows_use_fewer_blocks() -> None:
    """After many rows, the answer to a few is that of one that never had more, bit by bit."""
    body, _ = stretched(precision="float32")
    dynamics = ReducedDynamics(body.stepper)
    rows = some_rows(body, 40)
    for count in (9, 40, 12):
        problem = dynamics.solve(rows[:count])
        expected = ReducedDynamics(body.stepper, row_capacity=count).solve(rows[:count])
        np.testing.assert_array_equal(problem.responses, expected.responses)
        np.testing.assert_array_equal(problem.muscle_map, expected.muscle_map)
        assert problem.iterations == expected.iterations


def test_rows_of_another_length_are_refused() -> None:
    body, _ = stretched()
    dynamics = ReducedDynamics(body.stepper, row_capacity=16)
    with pytest.raises(InputError, match="rows of 189"):
        dynamics.solve(np.zeros((3, 7)))


def test_two_levels_converge_too() -> None:
    """As for a mesh too large to factorise."""
    body, matrix = stretched((0, 1, 5, 40), preconditioner="two_level")
    assert body.model.system.coarse is not None
    rows = some_rows(body, 20)
    free = (matrix - np.eye(len(matrix))).any(axis=1)
    problem = ReducedDynamics(body.stepper, row_capacity=20).solve(rows)
    left = (rows - problem.responses @ matrix) * free
    assert (np.linalg.norm(left, axis=1) <= 1.001e-3 * np.linalg.norm(rows, axis=1)).all()
    assert problem.iterations <= 20
