"""Kicks are left out where the steps before say that they find nothing, and come back."""

from __future__ import annotations

from dataclasses import replace

from tests.support.contact_problems import soft_body
from warp_softbody.controllers import ControlOptions, QPCCResult, SolverOptions, solve_qpcc
from warp_softbody.controllers.perturbation_schedule import PerturbationSchedule

CALM, HELD = 0.03, 5
OPTIONS = ControlOptions(
    max_qps=16, kicks=2, kick_patience=1, kick_reach=1.0, calm_objective=CALM, kick_pause=HELD
)
KICKED = SolverOptions(max_qps=16, kicks=2, patience=1, reach=1.0)
QUIET = replace(KICKED, kicks=0)
MODES = (1, 1)


def result(objective: float, modes: tuple[int, ...] = MODES) -> QPCCResult:
    solved = solve_qpcc(soft_body(0, contacts=2, controls=8), start=MODES)
    return replace(solved, objective=objective, modes=modes)


def test_modes_that_have_held_for_a_while_are_kicked_once_in_so_many_steps() -> None:
    rule, restless = PerturbationSchedule(OPTIONS), result(2.0 * CALM)
    assert rule.options() == KICKED
    steps = range(1, 4 * HELD + 1)
    left_out = [rule.note(MODES, restless, usable=True) for _ in steps]
    assert left_out == [i > HELD and i % HELD != 0 for i in steps]
    assert rule.options() == replace(KICKED, kick_held=False)


def test_without_a_pause_every_step_is_free_to_kick() -> None:
    rule = PerturbationSchedule(replace(OPTIONS, kick_pause=0))
    for _ in range(3):
        assert not rule.note(MODES, result(2.0 * CALM), usable=True)
        assert rule.options() == KICKED


def test_new_modes_bring_kicks_back() -> None:
    rule = PerturbationSchedule(OPTIONS)
    for start, modes in ((MODES, (1, 0)), (None, MODES)):
        for _ in range(HELD):
            rule.note(MODES, result(2.0 * CALM), usable=True)
        assert rule.options() != KICKED
        assert not rule.note(start, result(2.0 * CALM, modes), usable=True)
        assert rule.options() == KICKED


def test_a_calm_step_is_followed_by_one_without_kicks() -> None:
    rule = PerturbationSchedule(OPTIONS)
    rule.note(MODES, result(0.5 * CALM, (1, 0)), usable=True)
    assert rule.options() == QUIET
    assert rule.note(MODES, result(2.0 * CALM, (1, 0)), usable=True)
    assert rule.options() == KICKED
    rule.note(MODES, result(0.5 * CALM), usable=False)
    assert rule.options() == KICKED


def test_a_step_taken_for_calm_that_is_not_is_solved_again_with_kicks() -> None:
    rule = PerturbationSchedule(OPTIONS)
    assert rule.retry(result(2.0 * CALM)) is None
    rule.note(MODES, result(0.5 * CALM), usable=True)
    assert rule.options() == QUIET
    assert rule.retry(result(0.5 * CALM)) is None
    assert rule.retry(result(2.0 * CALM)) == KICKED
    assert rule.retry(result(2.0 * CALM)) is None
    assert not rule.note(MODES, result(2.0 * CALM, (1, 0)), usable=True)


def test_without_kicks_at_held_modes_others_are_kicked_all_the_same() -> None:
    calls = {True: 0, False: 0}
    for seed in range(6):
        problem = soft_body(seed, contacts=4, controls=12)
        for kick_held in calls:
            options = SolverOptions(kicks=4, kick_held=kick_held)
            first = solve_qpcc(problem, start=(1,) * 4, options=options)
            again = solve_qpcc(problem, start=first.modes, options=options)
            calls[kick_held] += again.qp_count
            assert again.objective <= first.objective + 1e-12
            plain = solve_qpcc(problem, start=first.modes, options=replace(options, kicks=0))
            if not kick_held and plain.modes == first.modes:
                assert again.qp_count == plain.qp_count
    assert calls[False] < calls[True]
