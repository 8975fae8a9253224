"""The QPCC search against full enumeration, on random soft bodies in contact."""

from __future__ import annotations

import glob
import itertools
from typing import Any

import numpy as np
import pytest

from warp_softbody.controllers.full_form import complementarity, force_map, full_point, to_full
from warp_softbody.controllers.lemke import forward_contact, lemke
from warp_softbody.controllers.piqp_backend import PIQPBackend
from warp_softbody.controllers.qp import QPProblem, QPStatus
from warp_softbody.controllers.qpcc import ContactQPCC, FloatArray, uniform_directions
from warp_softbody.controllers.reduced import ReducedProblem
from warp_softbody.controllers.result import QPCCResult, QPCCStatus, SolverOptions
from warp_softbody.controllers.solver import enumerate_qpcc, solve_qpcc, solve_static
from warp_softbody.errors import InputError

CERTIFIED = sorted(glob.glob("/work/shared/qpcc/contact_3d_nc8_*.npz"))


def soft_body(seed: int, *, contacts: int, controls: int, directions: int = 8) -> ContactQPCC:
    """Contacts on a random soft body of 30 more unknowns; eight momentum-like rows to be met."""
    rng = np.random.default_rng(seed)
    size, k = 3 * contacts + 30, 3 * contacts
    factor = rng.normal(size=(size, size))
    mobility = factor @ factor.T / size + 0.05 * np.eye(size)
    muscles = 0.6 * rng.normal(size=(size, controls))
    velocity = 0.5 * rng.normal(size=size)
    velocity[0:k:3] -= 0.8 * rng.random(contacts)
    rows = rng.normal(size=(8, size))
    slopes = np.hstack([rows @ mobility @ muscles, rows @ mobility[:, :k]])
    error = rows @ velocity + 0.5 * rng.normal(size=8)
    effort = np.diag(np.r_[np.full(controls, 1e-2), np.zeros(k)])
    return ContactQPCC(
        hessian=slopes.T @ slopes + effort,
        gradient=slopes.T @ error,
        constant=0.5 * float(error @ error),
        lower=np.full(controls, -0.5),
        upper=np.full(controls, 0.5),
        velocity_offset=velocity[:k],
        velocity_from_controls=(mobility @ muscles)[:k],
        velocity_from_forces=mobility[:k, :k],
        friction=np.full(contacts, 0.7),
        directions=uniform_directions(directions),
    )


def relative_gap(result: QPCCResult, reference: QPCCResult) -> float:
    return (result.objective - reference.objective) / (1e-3 + abs(reference.objective))


def enumerate_pairs(problem: ContactQPCC) -> float:
    """Least objective over all 2^pairs choices of a zero side in the full form, without pieces."""
    full, best = to_full(problem), np.inf
    backend = PIQPBackend()
    left, right = np.c_[full.L, full.l0], np.c_[full.R, full.r0]
    for choice in itertools.product((False, True), repeat=len(full.l0)):
        side = np.array(choice)
        zero, positive = left.copy(), right.copy()
        zero[side], positive[side] = right[side], left[side]
        solution = backend.solve(
            QPProblem(
                P=full.Q,
                c=full.c,
                A=zero[:, :-1],
                b=-zero[:, -1],
                G=positive[:, :-1],
                h=-positive[:, -1],
                lower=full.lb,
                upper=full.ub,
            )
        )
        if solution.status is QPStatus.SOLVED:
            best = min(best, solution.value + full.c0)
    return best


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


def test_more_kicks_are_never_worse_and_the_static_baseline_never_better() -> None:
    for seed in range(10):
        problem = soft_body(seed, contacts=4, controls=24)
        static = solve_static(problem)
        plain = solve_qpcc(problem, options=SolverOptions(kicks=0))
        kicked = solve_qpcc(problem, options=SolverOptions(kicks=20, max_qps=80))
        assert kicked.objective <= plain.objective <= static.objective + 1e-9
        assert max(r.complementarity for r in (static, plain, kicked)) < 1e-8


def test_a_warm_start_from_the_answer_stays_there_with_one_qp() -> None:
    problem = soft_body(5, contacts=4, controls=48)
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


def test_the_forward_problem_is_solved_at_any_controls() -> None:
    for seed, contacts in itertools.product(range(15), (1, 4, 8)):
        problem = soft_body(seed, contacts=contacts, controls=10)
        reduced = ReducedProblem(problem, PIQPBackend())
        controls = np.random.default_rng(seed).uniform(-1.0, 1.0, size=10)
        found = forward_contact(reduced, controls)
        assert found is not None
        forces = reduced.points_at(controls, found[1])[:, :3] * reduced.impulse
        u = controls * reduced.control_scale
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


@pytest.mark.skipif(not CERTIFIED, reason="the certified instances are not part of the project")
@pytest.mark.parametrize("path", CERTIFIED)
def test_certified_global_minima_are_reached(path: str) -> None:
    data = np.load(path)
    problem = read_instance(data)
    result = solve_qpcc(problem, options=SolverOptions(kicks=40, max_qps=120))
    assert result.complementarity < 1e-8
    gain = solve_static(problem).objective - float(data["f_best"])
    assert -1e-4 * gain < result.objective - float(data["f_best"]) < 5e-3 * gain


def read_instance(data: dict[str, FloatArray]) -> ContactQPCC:
    """A stored instance in general form (directions are +t1, -t1, +t2, -t2 in some order)."""
    k, m, nu = int(data["nc"]), int(data["m_dirs"]), int(data["nu"])
    physics: dict[str, Any] = {
        "lower": data["lb"][:nu],
        "upper": data["ub"][:nu],
        "velocity_offset": data["v0"],
        "velocity_from_controls": data["B"],
        "velocity_from_forces": data["W"],
    }
    rows = data["R"][1 : m + 1, :nu]
    directions = np.linalg.lstsq(data["B"][1:3].T, rows.T, rcond=None)[0].T
    order = np.argsort(np.round(np.arctan2(directions[:, 1], directions[:, 0]), 9) % (2 * np.pi))
    directions = directions[order] / np.linalg.norm(directions[order], axis=1)[:, None]
    law: dict[str, Any] = {"friction": np.full(k, float(data["mu"])), "directions": directions}
    size = nu + 3 * k
    bare = ContactQPCC(hessian=np.zeros((size, size)), gradient=np.zeros(size), **physics, **law)
    within = [nu + (m + 2) * i + np.r_[0, 1 + order, m + 1] for i in range(k)]
    column = np.concatenate([np.arange(nu), *within])
    back = np.linalg.pinv(force_map(bare))
    problem = ContactQPCC(
        hessian=back.T @ data["Q"][np.ix_(column, column)] @ back,
        gradient=back.T @ data["c"][column],
        constant=float(data["c0"]),
        **physics,
        **law,
    )
    full, pairs = to_full(problem), column[nu:] - nu
    np.testing.assert_allclose(full.Q, data["Q"][np.ix_(column, column)], atol=1e-9)
    np.testing.assert_allclose(full.R, data["R"][np.ix_(pairs, column)], atol=1e-9)
    np.testing.assert_allclose(full.r0, data["r0"][pairs], atol=1e-9)
    return problem
