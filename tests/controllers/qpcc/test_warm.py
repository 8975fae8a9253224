"""Warm starts: never worse than static contacts, and the same answer by every way to it."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.support.contact_problems import repeated, soft_body
from warp_softbody.controllers import ContactQPCC, QPCCStatus, SolverOptions
from warp_softbody.controllers.qp.daqp import DAQPSolver
from warp_softbody.controllers.qpcc.contact.mode_qp import ScaledContactQPCC
from warp_softbody.controllers.qpcc.next_minima import OTHERS
from warp_softbody.controllers.qpcc.solve import enumerate_qpcc, solve_qpcc, solve_static
from warp_softbody.errors import InputError

MODES = 18


def starts(seed: int, contacts: int, count: int) -> list[tuple[int, ...]]:
    rng = np.random.default_rng(seed)
    return [tuple(rng.integers(0, MODES, size=contacts).tolist()) for _ in range(count)]


def never_worse(problem: ContactQPCC, start: tuple[int, ...], options: SolverOptions) -> None:
    touching = np.array([mode != 0 for mode in start])
    for holds in (None, touching):
        static = solve_static(problem, touching=holds)
        result = solve_qpcc(problem, start=start, touching=holds, options=options)
        if static.status is QPCCStatus.STATIC:
            # Objectives of one point by two ways of rounding: 1e-13 of the curvature of one.
            assert result.objective <= static.objective + 1e-12


@pytest.mark.parametrize("kicks", [0, 2])
@pytest.mark.parametrize("contacts", [1, 4, 8])
def test_from_any_start_the_result_is_never_worse_than_static_contacts(
    contacts: int, kicks: int
) -> None:
    options = SolverOptions(kicks=kicks)
    for seed in range(8):
        problem = soft_body(seed, contacts=contacts, controls=12)
        for start in starts(seed, contacts, 3):
            never_worse(problem, start, options)


def test_two_qps_are_enough_for_that() -> None:
    for seed in range(8):
        problem = soft_body(seed, contacts=4, controls=12)
        for start in starts(seed, 4, 3):
            never_worse(problem, start, SolverOptions(max_qps=2))


def test_negative_values_and_no_constant_change_nothing_of_it() -> None:
    for seed, start in zip(range(8), starts(0, 4, 8), strict=True):
        problem = soft_body(seed, contacts=4, controls=12)
        never_worse(replace(problem, constant=-10.0), start, SolverOptions(kicks=0))


def test_redundant_contacts_that_disagree_hold_nowhere() -> None:
    """Two contacts at one place whose gaps differ cannot both close; one of them can."""
    problem = repeated(soft_body(0, contacts=2, controls=8), [0, 1, 0])
    offset = problem.velocity_offset.copy()
    scaled = ScaledContactQPCC(problem, DAQPSolver())
    assert scaled.solve((1, 1, 1)) is not None
    offset[6] += 1e-5 * problem.scales[0]
    scaled = ScaledContactQPCC(replace(problem, velocity_offset=offset), DAQPSolver())
    assert scaled.solve((1, 1, 1)) is None
    assert scaled.solve((1, 1, 0)) is not None


def test_a_limit_above_the_value_changes_nothing_and_one_below_ends_early() -> None:
    for seed, modes in itertools.product(range(4), [(1, 1, 1, 1), (2, 1, 11, 0)]):
        scaled = ScaledContactQPCC(soft_body(seed, contacts=4, controls=12), DAQPSolver())
        node = scaled.solve(modes)
        if node is None:
            continue
        above = scaled.solve(modes, limit=node.value + 1e-6)
        assert above is not None and above.value == node.value
        assert scaled.solve(modes, limit=node.value - 1e-6) is None


def test_a_short_reach_saves_qps_and_an_endless_one_changes_nothing() -> None:
    near = far = 0
    for seed, start in zip(range(8), starts(1, 4, 8), strict=True):
        problem = soft_body(seed, contacts=4, controls=12)
        endless, long, short = (
            solve_qpcc(problem, start=start, options=SolverOptions(reach=reach))
            for reach in (np.inf, 1e12, 0.1)
        )
        assert (long.objective, long.qp_count) == (endless.objective, endless.qp_count)
        near, far = near + short.qp_count, far + long.qp_count
    assert near < far
    with pytest.raises(InputError, match="reach must be a positive number"):
        SolverOptions(reach=0.0)


def test_touching_contacts_are_one_truth_value_each() -> None:
    problem = soft_body(0, contacts=2, controls=4)
    with pytest.raises(InputError, match="touching must be 2 truth values"):
        solve_qpcc(problem, start=(1, 1), touching=np.ones(3, dtype=bool))


def test_a_sequence_of_warm_starts_is_the_same_every_time() -> None:
    def follow() -> list[float]:
        modes: tuple[int, ...] = (1, 1, 1, 1)
        values = []
        for seed in range(10):
            result = solve_qpcc(soft_body(seed, contacts=4, controls=12), start=modes)
            modes = result.modes
            values.append(result.objective)
        return values

    assert follow() == follow()


def test_what_came_next_to_the_best_is_handed_on_and_begun_from() -> None:
    """From a poor start alone, and from there with the minima that a long search came by."""
    thorough = SolverOptions(kicks=60, patience=60, max_qps=400)
    alone = SolverOptions(kicks=0)
    gained = 0
    for seed in range(8):
        problem = soft_body(seed, contacts=4, controls=12)
        (start,) = starts(seed, 4, 1)
        best = solve_qpcc(problem, start=start, options=thorough)
        assert best.modes not in best.others and len(set(best.others)) == len(best.others) <= OTHERS
        values = [solve_qpcc(problem, start=one, options=alone).objective for one in best.others]
        assert min([*values, np.inf]) >= best.objective - 1e-10
        plain = solve_qpcc(problem, start=start, options=alone)
        beside = solve_qpcc(problem, start=start, others=(best.modes,), options=alone)
        assert beside.objective <= plain.objective + 1e-12
        assert beside.objective == pytest.approx(best.objective, rel=1e-9, abs=1e-12)
        gained += beside.objective < plain.objective - 1e-9
    assert gained >= 1


@pytest.mark.parametrize(
    ("others", "word"),
    [(((1, 1),), "4 modes"), (((1, 1, 1, 99),), "99"), (3, "others"), (("abcd",), "a")],
)
def test_wrong_further_starts_are_one_sentence(others: Any, word: str) -> None:
    problem = soft_body(0, contacts=4, controls=12)
    with pytest.raises(InputError, match=word):
        solve_qpcc(problem, start=(1, 1, 1, 1), others=others)


@pytest.mark.parametrize("friction", [1e5, 1e9, 1e300])
def test_friction_beyond_all_others_is_solved_like_very_high_friction(friction: float) -> None:
    for seed in range(6):
        plain = soft_body(seed, contacts=3, controls=12)
        high = replace(plain, friction=np.full(3, 1e3))
        beyond = replace(plain, friction=np.full(3, friction))
        for start in (None, (1, 1, 1)):
            expected, found = solve_qpcc(high, start=start), solve_qpcc(beyond, start=start)
            assert found.status is expected.status is not QPCCStatus.INACCURATE
            assert found.objective == expected.objective
            sticking = solve_static(beyond)
            assert sticking.status is QPCCStatus.STATIC
            np.testing.assert_allclose(sticking.velocities, 0.0, atol=1e-9)


def test_a_warm_solve_that_is_asked_gives_a_bound_that_no_point_falls_short_of() -> None:
    asked = SolverOptions(patience=1, reach=1.0, bound=True)
    for seed in range(6):
        problem = soft_body(seed, contacts=2, controls=8)
        start = starts(seed, 2, 1)[0]
        found = solve_qpcc(problem, start=start, options=asked)
        plain = solve_qpcc(problem, start=start, options=replace(asked, bound=False))
        assert plain.lower_bound == -np.inf and plain.gap == np.inf
        assert found.modes == plain.modes and found.objective == plain.objective
        assert found.qp_count == plain.qp_count + 1
        least = enumerate_qpcc(problem).objective
        assert -np.inf < found.lower_bound <= least + 1e-9 * (1.0 + abs(least))
        assert 0.0 <= found.gap < np.inf


def test_without_contacts_the_minimum_is_its_own_bound() -> None:
    problem = soft_body(0, contacts=1, controls=8)
    free = ContactQPCC(
        hessian=problem.hessian[:8, :8],
        gradient=problem.gradient[:8],
        lower=problem.lower,
        upper=problem.upper,
        velocity_offset=np.zeros(0),
        velocity_from_controls=np.zeros((0, 8)),
        velocity_from_forces=np.zeros((0, 0)),
        friction=np.zeros(0),
    )
    found = solve_qpcc(free, start=())
    assert found.lower_bound == found.objective and found.gap == 0.0
