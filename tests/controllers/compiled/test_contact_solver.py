"""Native solves of the contact QPCC against the NumPy form, on steps of scenes and at random."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from tests.support.contact_problems import repeated, soft_body
from warp_softbody.controllers import ContactQPCC, SolverOptions, control_solver, solve_qpcc
from warp_softbody.controllers.compiled import contact_solver
from warp_softbody.controllers.compiled.contact_solver import CompiledSearch, sizes_of
from warp_softbody.controllers.qpcc.contact import (
    force_elimination,
    kkt_residual,
    local_search,
    mode_cones,
    warm_start,
)
from warp_softbody.controllers.qpcc.contact import mode_table as modes_of
from warp_softbody.controllers.qpcc.contact.mode_table import mode_table
from warp_softbody.controllers.qpcc.next_minima import OTHERS
from warp_softbody.controllers.qpcc.result import QPCCResult
from warp_softbody.kernels.control.contact_search import LIMITS
from warp_softbody.kernels.control.search_layout import MOST_OTHERS
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes import make

EFFORT = 1e-2
"""Of ``soft_body``: what its Hessian has on the diagonal of the controls beyond eight squares."""


@dataclass(frozen=True)
class Asked:
    """What a control solver asked of ``solve_qpcc``, but for the problem, and what came back."""

    problem: ContactQPCC
    arguments: dict[str, Any]
    result: QPCCResult


def with_squares(problem: ContactQPCC) -> ContactQPCC:
    """The same problem, with its eight squares read off the Hessian."""
    rest = problem.hessian.copy()
    controls = np.arange(problem.control_count)
    rest[controls, controls] -= EFFORT
    sizes, vectors = np.linalg.eigh(rest)
    return replace(problem, squares=(vectors[:, -8:] * np.sqrt(sizes[-8:])).T)


def steps_of(name: str, count: int, monkeypatch: pytest.MonkeyPatch) -> list[Asked]:
    """The problems of the first steps of a scene, with the NumPy form's results."""
    asked: list[Asked] = []

    def noted(problem: ContactQPCC, **arguments: Any) -> QPCCResult:
        asked.append(Asked(problem, arguments, solve_qpcc(problem, **arguments)))
        return asked[-1].result

    monkeypatch.setattr(CompiledSearch, "solve_step", lambda *_, **__: None)
    monkeypatch.setattr(control_solver, "solve_qpcc", noted)
    plan = make(name)
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    for _ in range(count):
        simulation.step()
    monkeypatch.undo()
    return asked


def natively(
    monkeypatch: pytest.MonkeyPatch, search: CompiledSearch, problem: ContactQPCC, **arguments: Any
) -> QPCCResult | None:
    """The native result, or None where the problem is left to the NumPy form."""
    monkeypatch.setattr(contact_solver, "solve_qpcc", lambda *_, **__: None)
    found = search.solve(problem, **arguments)
    monkeypatch.undo()
    return found


def same(one: QPCCResult, other: QPCCResult, problem: ContactQPCC) -> None:
    """Both are the same point, to the rounding of a QP whose curvatures span four decades."""
    impulse, reach = problem.scales[1], np.abs(problem.upper - problem.lower).max()
    assert one.status is other.status
    np.testing.assert_allclose(one.controls, other.controls, atol=1e-9 * reach)
    np.testing.assert_allclose(one.forces, other.forces, atol=1e-8 * impulse)
    np.testing.assert_allclose(one.velocities, other.velocities, atol=1e-8 * problem.scales[0])
    np.testing.assert_allclose(one.x, other.x, atol=1e-8 * max(*problem.scales, reach))
    np.testing.assert_allclose(one.objective, other.objective, rtol=1e-7, atol=1e-12)
    assert max(one.complementarity, one.feasibility) < 1e-10
    assert one.stationarity < 1e-8


@pytest.mark.parametrize("name", ["balance-i", "crawl-i", "jump-t", "slide-f", "walk-x"])
def test_steps_of_a_scene_are_solved_as_the_numpy_form_does(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    search, left = CompiledSearch(), 0
    asked = steps_of(name, 24, monkeypatch)
    for each in asked:
        found = natively(monkeypatch, search, each.problem, **each.arguments)
        left += found is None
        if found is None or found.modes != each.result.modes:
            # DAQP now and then takes a feasible QP for one without a point
            assert found is None or found.objective < each.result.objective
            continue
        same(found, each.result, each.problem)
    assert left <= len(asked) // 4


@pytest.mark.parametrize("contacts", [1, 3, 6])
def test_random_problems_from_any_start(contacts: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(contacts)
    search, alike, tried = CompiledSearch(), 0, 0
    for seed in range(12):
        problem = with_squares(soft_body(seed, contacts=contacts, controls=40))
        start = tuple(rng.integers(0, 18, size=contacts).tolist())
        arguments: dict[str, Any] = {
            "start": start,
            "fallback_controls": np.zeros(40),
            "touching": rng.random(contacts) < 0.7,
            "options": SolverOptions(patience=3, reach=1.0) if seed % 2 else SolverOptions(kicks=0),
        }
        found = natively(monkeypatch, search, problem, **arguments)
        expected = solve_qpcc(problem, **arguments)
        if found is None:
            continue
        tried += 1
        assert found.complementarity < 1e-10 and found.stationarity < 1e-8
        if found.modes == expected.modes:
            same(found, expected, problem)
            alike += found.qp_count == expected.qp_count
    # a tie within rounding may send the two to different minima, or one by another way
    assert tried >= 10 and alike >= tried - 1


@pytest.mark.parametrize("contacts", [2, 4])
def test_further_starts_and_common_kicks_are_those_of_the_numpy_form(
    contacts: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(contacts)
    search, alike, handed_on = CompiledSearch(), 0, 0
    for seed in range(12):
        problem = with_squares(soft_body(seed, contacts=contacts, controls=40))
        start, *others = rng.integers(0, 18, size=(4, contacts)).tolist()
        arguments: dict[str, Any] = {
            "start": tuple(start),
            "others": tuple(map(tuple, others)),
            "fallback_controls": np.zeros(40),
            "touching": np.ones(contacts, dtype=bool),
            "options": SolverOptions(patience=12, kicks=20, max_qps=100),
        }
        found = natively(monkeypatch, search, problem, **arguments)
        expected = solve_qpcc(problem, **arguments)
        assert found is not None and len(found.others) <= OTHERS
        alike += found.modes == expected.modes and found.qp_count == expected.qp_count
        values = [
            [
                solve_qpcc(problem, start=modes, options=SolverOptions(kicks=0)).objective
                for modes in one
            ]
            for one in (found.others[:1], expected.others[:1])
        ]
        # pieces that share a point have one value, and may stand in either order
        handed_on += values[0] == pytest.approx(values[1], rel=1e-6)
    # redundant contacts, which this form passes over, and ties within rounding make a difference
    assert alike >= 10 and handed_on >= 11


@pytest.mark.parametrize("reach", [1e-3, 0.1, 3.0])
def test_kicks_that_would_end_high_are_given_up_alike(
    reach: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A QP that the dual value ends early counts as one whose minimum is above the limit."""
    search, alike, spared = CompiledSearch(), 0, 0
    options = SolverOptions(patience=20, kicks=40, max_qps=120, reach=reach)
    for seed in range(10):
        problem = with_squares(soft_body(seed, contacts=4, controls=40))
        arguments: dict[str, Any] = {
            "start": (1,) * 4,
            "fallback_controls": np.zeros(40),
            "touching": np.ones(4, dtype=bool),
        }
        found = natively(monkeypatch, search, problem, **arguments, options=options)
        expected = solve_qpcc(problem, **arguments, options=options)
        assert found is not None
        if found.modes == expected.modes:
            same(found, expected, problem)
            alike += 1
        unlimited = replace(options, reach=np.inf)
        every = natively(monkeypatch, search, problem, **arguments, options=unlimited)
        assert every is not None and every.qp_count <= options.max_qps
        spared += every.qp_count > found.qp_count
    assert alike >= 9 and (reach > 1.0 or spared >= 8)


def test_both_forms_hand_on_as_many_minima() -> None:
    assert MOST_OTHERS == OTHERS


@pytest.mark.parametrize("directions", [3, 4, 8])
def test_cones_are_those_of_the_mode_table(directions: int) -> None:
    """Of contacts with and without friction, with unequal factors, and after these change."""
    rng = np.random.default_rng(directions)
    plain = with_squares(soft_body(0, contacts=4, controls=40, directions=directions))
    search = CompiledSearch()
    friction = np.array([0.7, 0.0, 0.3, 1.2])
    for factors in (np.ones((4, directions)), *rng.uniform(0.2, 3.0, (3, 4, directions))):
        problem = replace(plain, friction=friction, factors=factors)
        search.solve(
            problem,
            start=(1,) * 4,
            fallback_controls=np.zeros(40),
            touching=np.ones(4, bool),
            options=SolverOptions(kicks=0),
        )
        room, table = search.rooms.of(sizes_of(problem)), mode_table(problem)
        np.testing.assert_array_equal(room.counts["valid"], table.valid)
        names = {"basis": "force_basis", "constraints": "velocity_constraints"}
        for name in ("basis", "constraints", "inequalities", "halfspaces", "rays"):
            expected = getattr(table, names.get(name, name))[table.valid]
            found = room.numbers[name][table.valid]
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14)
        for name, other in (("dimensions", "force_dimensions"), ("used", "inequality_used")):
            expected = getattr(table, other)[table.valid]
            np.testing.assert_array_equal(room.counts[name][table.valid], expected)


def test_without_a_start_and_without_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    search = CompiledSearch()
    options = SolverOptions(starts=0)
    for contacts in (0, 2):
        problem = with_squares(soft_body(1, contacts=contacts, controls=40))
        arguments: dict[str, Any] = {
            "start": None,
            "fallback_controls": np.zeros(40),
            "touching": np.ones(contacts, bool),
            "options": options,
        }
        found = natively(monkeypatch, search, problem, **arguments)
        assert found is not None
        same(found, solve_qpcc(problem, **arguments), problem)


def test_redundant_contacts_that_disagree_have_no_point_and_the_others_are_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    agreeing = repeated(with_squares(soft_body(0, contacts=2, controls=40)), [0, 1, 0])
    arguments: dict[str, Any] = {
        "start": (1, 1, 1),
        "fallback_controls": np.zeros(40),
        "touching": np.ones(3, bool),
        "options": SolverOptions(kicks=0),
    }
    assert natively(monkeypatch, CompiledSearch(), agreeing, **arguments) is None
    offset = agreeing.velocity_offset.copy()
    offset[6] += 1e-5 * agreeing.scales[0]
    apart = replace(agreeing, velocity_offset=offset)
    arguments |= {"start": (1, 1, 0), "touching": np.ones(3, bool)}
    found = natively(monkeypatch, CompiledSearch(), apart, **arguments)
    assert found is not None
    same(found, solve_qpcc(apart, **arguments), apart)


def test_a_solve_is_the_same_to_rounding_wherever_the_one_before_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first, second = (with_squares(soft_body(s, contacts=3, controls=40)) for s in (1, 2))
    arguments: dict[str, Any] = {
        "start": (1, 1, 1),
        "fallback_controls": np.zeros(40),
        "touching": np.ones(3, bool),
        "options": SolverOptions(),
    }
    search = CompiledSearch()
    fresh = natively(monkeypatch, search, first, **arguments)
    natively(monkeypatch, search, second, **arguments)
    again = natively(monkeypatch, search, first, **arguments)
    assert fresh is not None and again is not None
    same(again, fresh, first)


def test_what_the_native_code_does_not_know_goes_to_the_numpy_form() -> None:
    problem = soft_body(0, contacts=2, controls=6)
    arguments: dict[str, Any] = {
        "start": (1, 1),
        "fallback_controls": np.zeros(6),
        "touching": np.ones(2, bool),
        "options": SolverOptions(),
    }
    one, other = CompiledSearch().solve(problem, **arguments), solve_qpcc(problem, **arguments)
    assert one.modes == other.modes and one.objective == other.objective


def test_both_forms_have_the_same_limits() -> None:
    homes = (force_elimination, kkt_residual, local_search, mode_cones, modes_of, warm_start)
    for name, value in LIMITS.items():
        for home in homes:
            if hasattr(home, name) and not (home is local_search and name == "SINGULAR"):
                assert getattr(home, name) == float(value), name
