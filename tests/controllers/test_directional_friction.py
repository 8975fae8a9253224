"""Friction by direction in the control problem: against enumeration of the pairs and by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from tests.support.contact_problems import MASS, WEIGHT_IMPULSE, block, enumerate_pairs, soft_body
from warp_softbody.arrays import FloatArray
from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.contact_mode import ContactMode
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qpcc.contact.complementarity_form import to_general
from warp_softbody.controllers.qpcc.contact.forward_lcp import forward_contact
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC, uniform_directions
from warp_softbody.controllers.qpcc.result import QPCCStatus
from warp_softbody.controllers.qpcc.solve import enumerate_qpcc, solve_qpcc

FRICTION = 0.5
LIMIT = FRICTION * WEIGHT_IMPULSE

BACKWARD = np.roll(DirectionalFriction(region="sole", factors=(1, 1, 10, 1)).eight, 4)
"""A sole that slides forward, along tangent 1, under a tenth of the friction it has backward; by
the direction of the force."""

ONE_CORNER = np.array([10.0, 1, 1, 1, 1, 1, 1, 1])
"""Its neighbours lie inside the hull of the long corner and the next ones."""


def uneven(seed: int, *, contacts: int, directions: int) -> ContactQPCC:
    """A soft body with one direction of friction ten times the others, drawn for each contact."""
    plain = soft_body(seed, contacts=contacts, controls=5, directions=directions)
    factors = np.ones((contacts, directions))
    long = np.random.default_rng(seed).integers(directions, size=contacts)
    factors[np.arange(contacts), long] = 10.0
    return replace(plain, factors=factors)


@pytest.mark.parametrize(("contacts", "directions"), [(1, 3), (1, 4), (1, 5), (2, 3)])
@pytest.mark.parametrize("seed", range(3))
def test_pieces_and_pairs_have_the_same_least_objective(
    seed: int, contacts: int, directions: int
) -> None:
    problem = uneven(seed, contacts=contacts, directions=directions)
    # Accepted QPs have scaled residuals and gaps of 1e-6 at most, and each side is one of them.
    by_pieces, by_pairs = enumerate_qpcc(problem).objective, enumerate_pairs(problem)
    np.testing.assert_allclose(by_pieces, by_pairs, rtol=1e-5, atol=1e-7)


@pytest.mark.parametrize("contacts", [1, 2])
@pytest.mark.parametrize("seed", range(4))
def test_the_solvers_of_both_forms_agree_with_enumeration(seed: int, contacts: int) -> None:
    problem = uneven(seed, contacts=contacts, directions=4)
    best = enumerate_qpcc(problem)
    assert best.status is QPCCStatus.GLOBAL and best.complementarity < 1e-8
    for result in (solve_qpcc(problem), solve_qpcc(to_general(problem))):
        np.testing.assert_allclose(result.objective, best.objective, rtol=1e-5, atol=1e-7)
        assert result.complementarity < 1e-8


def test_factors_of_one_are_the_default_to_the_last_bit() -> None:
    plain = soft_body(3, contacts=4, controls=8)
    ones = replace(plain, factors=np.ones((4, 8)))
    one, other = solve_qpcc(plain, budget=40), solve_qpcc(ones, budget=40)
    np.testing.assert_array_equal(one.x, other.x)
    assert one.modes == other.modes and one.qp_count == other.qp_count


def strength(factors: FloatArray, along: FloatArray) -> float:
    """How far the polygon of the corners mu S_j d_j reaches ``along``, by a linear program."""
    corners = FRICTION * factors[:, None] * uniform_directions(len(factors))
    count = len(factors)
    # Largest t with t along = sum_j b_j corner_j, b >= 0, sum b <= 1.
    answer = linprog(
        np.r_[-1.0, np.zeros(count)],
        A_ub=np.r_[0.0, np.ones(count)][None],
        b_ub=[1.0],
        A_eq=np.column_stack([-along, corners.T]),
        b_eq=np.zeros(2),
    )
    return -float(answer.fun or 0.0)


def pushed(factors: FloatArray, push: FloatArray) -> Any:
    """A block without controls under an impulse along the ground, from rest, all sticking."""
    x, y = push.tolist()
    nothing: dict[str, Any] = {"velocity_from_controls": np.zeros((3, 1)), "factors": factors[None]}
    return solve_qpcc(block((0.0, x, y), friction=FRICTION, **nothing), start=(1,))


@pytest.mark.parametrize("direction", range(8))
@pytest.mark.parametrize("factors", [BACKWARD, ONE_CORNER], ids=["backward", "one corner"])
def test_a_pulled_block_holds_up_to_the_polygon_and_slides_beyond(
    factors: FloatArray, direction: int
) -> None:
    along = uniform_directions(8)[direction]
    limit = strength(factors, -along) * WEIGHT_IMPULSE
    held, slipping = (
        pushed(factors, (1.0 - 1e-6) * limit * along),
        pushed(factors, (1.0 + 1e-6) * limit * along),
    )
    assert held.contact_modes == (ContactMode.STICK,)
    np.testing.assert_allclose(held.velocities, 0.0, atol=1e-12)
    assert slipping.contact_modes == (ContactMode.SLIDE,)
    assert np.linalg.norm(slipping.velocities) > 1e-7 * limit / MASS
    assert max(held.complementarity, slipping.complementarity) < 1e-8


@pytest.mark.parametrize("direction", range(8))
@pytest.mark.parametrize("factors", [BACKWARD, ONE_CORNER], ids=["backward", "one corner"])
def test_a_sliding_block_meets_the_friction_of_its_own_way(
    factors: FloatArray, direction: int
) -> None:
    along = uniform_directions(8)[direction]
    result = pushed(factors, 20.0 * LIMIT * along)
    against = factors[(direction + 4) % 8] * LIMIT
    np.testing.assert_allclose(result.forces[0, 1:], -against * along, rtol=1e-9, atol=1e-12)
    speed = (20.0 * LIMIT - against) / MASS
    np.testing.assert_allclose(result.velocities[0, 1:], speed * along, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_the_forward_problem_has_a_point_at_any_controls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turned = np.array([np.roll(BACKWARD, shift) for shift in rng.integers(8, size=6)])
    problem = replace(soft_body(seed, contacts=6, controls=6), factors=turned)
    scaled = ScaledContactQPCC(problem, PIQPSolver())
    for controls in scaled.lower + (scaled.upper - scaled.lower) * rng.random((5, 6)):
        found = forward_contact(scaled, controls)
        assert found is not None
        violation = scaled.table.violation(scaled.points_at(controls, found[1]))
        assert violation.min(axis=1).max() < 1e-7
