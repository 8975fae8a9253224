"""The QPCC search against full enumeration, on random soft bodies in contact."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tests.support.contact_problems import enumerate_pairs, soft_body
from warp_softbody.controllers.qp.piqp import PIQPSolver
from warp_softbody.controllers.qpcc.contact.complementarity_form import (
    complementarity,
    force_map,
    full_point,
)
from warp_softbody.controllers.qpcc.contact.forward_lcp import forward_contact, lemke
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.result import QPCCResult, QPCCStatus, SolverOptions
from warp_softbody.controllers.qpcc.solve import enumerate_qpcc, solve_qpcc, solve_static
from warp_softbody.errors import InputError


def relative_gap(result: QPCCResult, reference: QPCCResult) -> float:
    return (result.objective - reference.objective) / (1e-3 + abs(reference.objective))


@pytest.mark.parametrize("seed", range(12))
def test_enumerating_pieces_equals_enumerating_complementarity_pairs(seed: int) -> None:
    problem = soft_body(seed, contacts=1, controls=5, directions=4)
    np.testing.assert_allclose(
        enumerate_qpcc(problem).objective, enumerate_pairs(problem), rtol=1e-5, atol=1e-7
    )


def check_against_enumeration(problems: list[ContactQPCC], options: SolverOptions | None) -> float:
    """Share of global minima found; asserts that no answer is better or inconsistent."""
    found = 0
    for problem in problems:
        reference, result = enumerate_qpcc(problem), solve_qpcc(problem, options=options)
        assert reference.status is QPCCStatus.GLOBAL
        gap = relative_gap(result, reference)
        assert gap > -1e-6
        assert result.complementarity < 1e-8 and result.feasibility == 0.0
        assert result.stationarity < 1e-6
        found += gap < 1e-6
    return found / len(problems)


def test_one_contact_reaches_the_global_minimum() -> None:
    problems = [soft_body(seed, contacts=1, controls=6) for seed in range(60)]
    assert check_against_enumeration(problems, None) == 1.0
    without = check_against_enumeration(problems, SolverOptions(kicks=0))
    assert 0.7 < without < 0.9


def test_two_contacts_reach_the_global_minimum_almost_always() -> None:
    problems = [soft_body(seed, contacts=2, controls=8, directions=4) for seed in range(40)]
    assert check_against_enumeration(problems, None) >= 0.95


def test_two_contacts_with_eight_directions() -> None:
    problems = [soft_body(seed, contacts=2, controls=12) for seed in range(12)]
    assert check_against_enumeration(problems, None) >= 0.9


def test_directional_friction_and_mixed_coefficients_against_enumeration() -> None:
    rng = np.random.default_rng(0)
    problems = []
    for seed in range(6):
        plain = soft_body(seed, contacts=2, controls=8, directions=4)
        uneven = np.where(rng.random((2, 4)) < 0.3, 10.0, 1.0)
        problems.append(replace(plain, factors=uneven))
        problems.append(replace(plain, friction=np.array([0.0, 10.0])))
        unbounded = np.full(8, np.inf)
        problems.append(replace(plain, lower=-unbounded, upper=unbounded))
    assert check_against_enumeration(problems, None) >= 0.95


@pytest.mark.parametrize("seed", range(4))
def test_a_duplicated_contact_changes_nothing(seed: int) -> None:
    single = soft_body(seed, contacts=1, controls=8, directions=4)
    twice = np.r_[0:3, 0:3]
    z = np.r_[0:8, 8 + twice]
    double = ContactQPCC(
        hessian=single.hessian[np.ix_(z, z)],
        gradient=single.gradient[z],
        constant=single.constant,
        lower=single.lower,
        upper=single.upper,
        velocity_offset=single.velocity_offset[twice],
        velocity_from_controls=single.velocity_from_controls[twice],
        velocity_from_forces=single.velocity_from_forces[np.ix_(twice, twice)],
        friction=np.full(2, 0.7),
        directions=single.directions,
    )
    expected, result = enumerate_qpcc(single).objective, solve_qpcc(double)
    np.testing.assert_allclose(enumerate_qpcc(double).objective, expected, rtol=1e-6, atol=1e-9)
    assert result.objective >= expected - 1e-8 and result.complementarity < 1e-8


def test_units_do_not_matter() -> None:
    problem = soft_body(4, contacts=2, controls=8, directions=4)
    control, force, speed, value = 1e2, 1e-4, 1e2, 1e-8
    z = np.r_[np.full(8, control), np.full(6, force)]
    other = ContactQPCC(
        hessian=value * problem.hessian * z[:, None] * z,
        gradient=value * problem.gradient * z,
        constant=value * problem.constant,
        lower=problem.lower / control,
        upper=problem.upper / control,
        velocity_offset=problem.velocity_offset / speed,
        velocity_from_controls=problem.velocity_from_controls * control / speed,
        velocity_from_forces=problem.velocity_from_forces * force / speed,
        friction=problem.friction,
        directions=problem.directions,
    )
    here, there = solve_qpcc(problem), solve_qpcc(other)
    assert here.modes == there.modes
    np.testing.assert_allclose(there.objective, value * here.objective, rtol=1e-8)
    np.testing.assert_allclose(there.controls * control, here.controls, atol=1e-6)


def test_more_kicks_are_never_worse_and_the_static_baseline_never_better() -> None:
    for seed in range(10):
        problem = soft_body(seed, contacts=4, controls=24)
        static = solve_static(problem)
        plain = solve_qpcc(problem, options=SolverOptions(kicks=0))
        kicked = solve_qpcc(problem, options=SolverOptions(kicks=20, max_qps=80))
        assert kicked.objective <= plain.objective <= static.objective + 1e-9
        assert max(r.complementarity for r in (static, plain, kicked)) < 1e-8


def test_kicks_end_when_patience_does() -> None:
    for seed in range(10):
        problem = soft_body(seed, contacts=2, controls=8)
        modes = solve_qpcc(problem).modes
        # From the best point known every kick is fruitless, and each is at least one QP.
        patient = solve_qpcc(problem, start=modes, options=SolverOptions(kicks=12, patience=12))
        hasty = solve_qpcc(problem, start=modes, options=SolverOptions(kicks=12, patience=3))
        same = solve_qpcc(problem, start=modes, options=SolverOptions(kicks=3))
        assert hasty.qp_count == same.qp_count < patient.qp_count
        assert hasty.objective == same.objective == patient.objective


@pytest.mark.parametrize("seed", [1, 6, 8])
def test_a_warm_start_from_the_answer_stays_there_with_one_qp(seed: int) -> None:
    """Static contacts are more than four times worse here, which a bound shows without a QP."""
    problem = soft_body(seed, contacts=4, controls=48)
    first = solve_qpcc(problem)
    again = solve_qpcc(problem, start=first.modes, options=SolverOptions(kicks=0))
    assert again.qp_count == 1 and again.modes == first.modes
    np.testing.assert_allclose(again.objective, first.objective, rtol=1e-9)


def test_the_same_problem_gives_the_same_answer() -> None:
    first, second = (solve_qpcc(soft_body(7, contacts=4, controls=24)) for _ in range(2))
    assert first.modes == second.modes and first.qp_count == second.qp_count
    np.testing.assert_array_equal(first.controls, second.controls)
    np.testing.assert_array_equal(first.forces, second.forces)


@pytest.mark.parametrize("limit", [1, 2, 3, 7])
def test_the_budget_of_qps_is_kept(limit: int) -> None:
    for seed in range(6):
        result = solve_qpcc(
            soft_body(seed, contacts=4, controls=12), options=SolverOptions(max_qps=limit)
        )
        assert result.qp_count <= limit
        assert result.complementarity < 1e-8


def test_without_time_the_forward_point_is_returned() -> None:
    problem = soft_body(1, contacts=4, controls=12)
    result = solve_qpcc(problem, options=SolverOptions(time_limit=1e-9))
    assert result.status is QPCCStatus.FALLBACK_LCP and result.qp_count == 0
    assert result.complementarity < 1e-8
    np.testing.assert_array_equal(result.controls, 0.0)


def test_the_forward_problem_is_solved_at_any_controls() -> None:
    for seed, contacts in itertools.product(range(15), (1, 4, 8)):
        problem = soft_body(seed, contacts=contacts, controls=10)
        scaled = ScaledContactQPCC(problem, PIQPSolver())
        controls = np.random.default_rng(seed).uniform(-1.0, 1.0, size=10)
        found = forward_contact(scaled, controls)
        assert found is not None
        forces = scaled.points_at(controls, found[1])[:, :3] * scaled.impulse
        u = controls * scaled.control_scale
        assert complementarity(problem, u, forces) < 1e-9
        x = full_point(problem, u, forces)
        np.testing.assert_allclose(force_map(problem) @ x, np.r_[u, forces.ravel()], atol=1e-12)


def test_lemke_solves_a_known_problem_and_says_when_there_is_no_solution() -> None:
    z = lemke(np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-5.0, -6.0]))
    assert z is not None
    np.testing.assert_allclose(z, [4.0 / 3.0, 7.0 / 3.0], atol=1e-7)
    assert lemke(np.array([[-1.0]]), np.array([-1.0])) is None


def test_enumeration_refuses_what_would_never_end() -> None:
    with pytest.raises(InputError, match="at most 4"):
        enumerate_qpcc(soft_body(0, contacts=5, controls=4))


def test_a_cold_search_of_contacts_kicks_before_it_turns_to_the_general_form() -> None:
    """So that a small budget finds what else the penalty method would find with a large one."""
    descents, kicked, long = [], [], []
    for seed in range(6):
        problem = soft_body(seed, contacts=8, controls=24)
        descents.append(
            solve_qpcc(problem, start=(1,) * 8, options=SolverOptions(kicks=0)).objective
        )
        kicked.append(solve_qpcc(problem, budget=400).objective)
        long.append(solve_qpcc(problem).objective)
    gained = np.array(descents) - np.array(kicked)
    assert gained.min() >= -1e-10 and gained.max() > 1e-4
    # of what the long search gains over a descent
    assert np.sum(gained) > 0.98 * np.sum(np.array(descents) - np.array(long))
