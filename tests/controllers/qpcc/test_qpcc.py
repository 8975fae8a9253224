"""The contact QPCC: Coulomb's law with known answers, input checks, statuses."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from tests.support.contact_problems import MASS, WEIGHT_IMPULSE, block
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qp.problem import QPProblem, QPStatus
from warp_softbody.controllers.qpcc.contact.complementarity_form import (
    complementarity,
    full_point,
    to_full,
)
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC, uniform_directions
from warp_softbody.controllers.qpcc.result import QPCCStatus, SolverOptions
from warp_softbody.controllers.qpcc.solve import enumerate_qpcc, solve_qpcc, solve_static
from warp_softbody.errors import InputError


def test_a_block_sticks_under_the_friction_limit() -> None:
    push = 0.9 * 0.5 * WEIGHT_IMPULSE
    result = solve_qpcc(block((0.0, push, 0.0)))
    assert result.contact_modes == (ContactMode.STICK,)
    np.testing.assert_allclose(result.forces[0], [WEIGHT_IMPULSE, -push, 0.0], atol=1e-7)
    np.testing.assert_allclose(result.velocities, 0.0, atol=1e-15)
    assert result.status is QPCCStatus.STRONGLY_STATIONARY


@pytest.mark.parametrize("direction", range(8))
def test_a_block_slides_over_the_friction_limit(direction: int) -> None:
    along, limit = uniform_directions(8)[direction], 0.5 * WEIGHT_IMPULSE
    push = 1.5 * limit * along
    result = solve_qpcc(block((0.0, float(push[0]), float(push[1]))))
    assert result.contact_modes == (ContactMode.SLIDE,)
    np.testing.assert_allclose(result.forces[0, 1:], -limit * along, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(result.velocities[0, 1:], 0.5 * limit * along / MASS, atol=1e-8)
    assert result.complementarity < 1e-12


def test_a_push_between_two_directions_slides_on_the_edge_of_the_cone() -> None:
    angle, limit = np.pi / 8, 0.5 * WEIGHT_IMPULSE
    along = np.array([np.cos(angle), np.sin(angle)])
    push = 3.0 * limit * along
    result = solve_qpcc(block((0.0, float(push[0]), float(push[1]))))
    # The polygon's edge is nearer than the circle by cos(pi/8).
    expected = -limit * np.cos(angle) * along
    np.testing.assert_allclose(result.forces[0, 1:], expected, rtol=1e-9)


def test_a_block_lifts_when_pulled_up() -> None:
    result = solve_qpcc(block((1.25 * WEIGHT_IMPULSE, 0.1, 0.0)))
    assert result.contact_modes == (ContactMode.LIFT,)
    np.testing.assert_array_equal(result.forces, 0.0)
    np.testing.assert_allclose(result.velocities[0, 0], 0.25 * WEIGHT_IMPULSE / MASS)


def test_a_wanted_control_is_reached_where_contact_allows_it() -> None:
    result = solve_qpcc(block((0.0, 0.0, 0.0), wanted=0.7))
    np.testing.assert_allclose(result.controls, [0.7], rtol=1e-7)
    bounded = solve_qpcc(block((0.0, 0.0, 0.0), wanted=0.7, upper=np.array([0.2])))
    np.testing.assert_allclose(bounded.controls, [0.2], rtol=1e-9)
    assert bounded.feasibility == 0.0


def test_without_friction_nothing_holds_back() -> None:
    result = solve_qpcc(block((0.0, 0.3, -0.2), friction=0.0))
    np.testing.assert_allclose(result.forces[0], [WEIGHT_IMPULSE, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(result.velocities[0], [0.0, 0.15, -0.1], atol=1e-12)
    assert result.complementarity < 1e-12


def test_friction_of_ten_holds_ten_times_the_weight() -> None:
    push = 9.0 * WEIGHT_IMPULSE
    result = solve_qpcc(block((0.0, push, 0.0), friction=10.0))
    assert result.contact_modes == (ContactMode.STICK,)
    np.testing.assert_allclose(result.forces[0, 1], -push, rtol=1e-9)


def test_directional_friction_holds_ten_times_more_against_one_direction() -> None:
    scale = np.ones((1, 8))
    scale[0, 4] = 10.0
    limit = 0.5 * WEIGHT_IMPULSE
    held = solve_qpcc(block((0.0, 6.0 * limit, 0.0), factors=scale))
    assert held.contact_modes == (ContactMode.STICK,)
    slipping = solve_qpcc(block((0.0, -6.0 * limit, 0.0), factors=scale))
    assert slipping.contact_modes == (ContactMode.SLIDE,)
    np.testing.assert_allclose(slipping.forces[0, 1], limit, rtol=1e-9)
    assert max(held.complementarity, slipping.complementarity) < 1e-10


def test_duplicate_contacts_share_the_load() -> None:
    single = block((0.0, 0.02, 0.0))
    twice = np.vstack([np.eye(3), np.eye(3)])
    double = block(
        (0.0, 0.02, 0.0),
        hessian=np.diag([1.0, *[0.0] * 6]),
        gradient=np.zeros(7),
        velocity_offset=np.tile(single.velocity_offset, 2),
        velocity_from_controls=np.tile(single.velocity_from_controls, (2, 1)),
        velocity_from_forces=twice @ twice.T / MASS,
    )
    result = solve_qpcc(double)
    assert result.complementarity < 1e-8
    np.testing.assert_allclose(result.forces.sum(axis=0), [WEIGHT_IMPULSE, -0.02, 0.0], atol=1e-8)
    np.testing.assert_allclose(result.objective, solve_qpcc(single).objective, atol=1e-9)


def test_without_contacts_it_is_a_box_qp() -> None:
    problem = ContactQPCC(
        hessian=np.eye(3),
        gradient=np.array([-2.0, 0.3, 5.0]),
        lower=np.full(3, -1.0),
        upper=np.array([1.0, np.inf, np.inf]),
        velocity_offset=np.zeros(0),
        velocity_from_controls=np.zeros((0, 3)),
        velocity_from_forces=np.zeros((0, 0)),
        friction=np.zeros(0),
    )
    for result in (solve_qpcc(problem), solve_static(problem), enumerate_qpcc(problem)):
        np.testing.assert_allclose(result.controls, [1.0, -0.3, -1.0], atol=1e-8)
        assert result.modes == () and result.complementarity == 0.0


@pytest.mark.parametrize("name", [entry.name for entry in fields(ContactQPCC)])
def test_nan_is_refused_with_the_name_of_the_field(name: str) -> None:
    squares = np.array([[0.5, 0.0, 0.0, 0.0]])
    good = block((0.0, 0.0, 0.0), factors=np.ones((1, 8)), squares=squares)
    value = np.array(getattr(good, name), dtype=float)
    value.reshape(-1)[0] = np.nan
    wrong: dict[str, Any] = {name: value}
    with pytest.raises(InputError, match=name):
        replace(good, **wrong)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gradient": np.zeros(3)}, "gradient must be"),
        ({"lower": np.array([1.0]), "upper": np.array([0.0])}, "leave no value"),
        ({"friction": -0.1}, "friction"),
        ({"hessian": -np.eye(4)}, "positive semidefinite"),
        ({"velocity_from_forces": np.triu(np.ones((3, 3)))}, "symmetric"),
        ({"directions": uniform_directions(8)[::-1]}, "directions"),
        ({"directions": uniform_directions(8)[:4]}, "directions"),
    ],
)
def test_unusable_input_is_refused_with_a_sentence(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        block((0.0, 0.0, 0.0), **changes)


def test_unusable_calls_are_refused() -> None:
    problem = block((0.0, 0.0, 0.0))
    for start in ((0, 0), (18,), (-1,)):
        with pytest.raises(InputError, match="start"):
            solve_qpcc(problem, start=start)
    with pytest.raises(InputError, match="fallback_controls"):
        solve_qpcc(problem, fallback_controls=np.array([np.nan]))
    with pytest.raises(InputError, match="max_qps"):
        SolverOptions(max_qps=0)
    with pytest.raises(InputError, match="no setting"):
        PIQPSolver(settings={"max_itre": 3})
    with pytest.raises(InputError, match="cannot be"):
        PIQPSolver(settings={"max_iter": "many"})


def test_an_infeasible_static_root_falls_back_to_the_forward_solution() -> None:
    # Free fall onto the ground while pushed hard sideways: no control, so sticking is impossible.
    problem = block((0.0, 5.0 * WEIGHT_IMPULSE, 0.0), velocity_from_controls=np.zeros((3, 1)))
    for result in (solve_qpcc(problem), solve_static(problem)):
        assert result.contact_modes == (ContactMode.SLIDE,)
        assert result.complementarity < 1e-12
    limited = solve_qpcc(problem, options=SolverOptions(max_qps=1))
    assert limited.status is QPCCStatus.FALLBACK_LCP and limited.qp_count == 1
    assert limited.complementarity < 1e-8


def test_piqp_says_infeasible_and_checks_its_own_answers() -> None:
    box: dict[str, Any] = {
        "P": np.eye(2),
        "c": np.array([-1.0, 0.0]),
        "A": np.zeros((0, 2)),
        "b": np.zeros(0),
        "lower": np.array([-np.inf, -np.inf]),
        "upper": np.array([np.inf, np.inf]),
    }
    row = np.array([[1.0, 1.0]])
    solved = PIQPSolver().solve(QPProblem(**box, G=-row, h=np.array([-0.5])))
    assert solved.status is QPStatus.SOLVED
    np.testing.assert_allclose(solved.x, [0.75, -0.25], atol=1e-8)
    np.testing.assert_allclose(solved.multipliers.rows, [0.25], atol=1e-8)
    crossed = QPProblem(**box, G=np.vstack([row, -row]), h=np.array([1.0, 1.0]))
    assert PIQPSolver().solve(crossed).status is QPStatus.INFEASIBLE
    early = PIQPSolver(settings={"max_iter": 1}).solve(QPProblem(**box, G=-row, h=np.array([-0.5])))
    assert early.status is QPStatus.UNSOLVED


@pytest.mark.parametrize("count", [3, 4, 8])
def test_the_full_form_agrees_with_the_fast_residual(count: int) -> None:
    rng = np.random.default_rng(count)
    problem = block((0.0, 0.1, 0.05), directions=uniform_directions(count))
    full = to_full(problem)
    for _ in range(20):
        controls, forces = rng.normal(size=1), rng.normal(size=(1, 3))
        x = full_point(problem, controls, forces)
        value = 0.5 * x @ full.Q @ x + full.c @ x + full.c0
        np.testing.assert_allclose(value, problem.objective(controls, forces))
        expected = full.complementarity(x)
        np.testing.assert_allclose(complementarity(problem, controls, forces), expected)
        assert expected > 1e-3
