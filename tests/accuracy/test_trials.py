"""Settings found by trials, on motions whose errors are known."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.accuracy import synthetic
from warp_softbody.accuracy.analysis.motion import Ruler
from warp_softbody.accuracy.analysis.trials import Trials, tuned_by_trials
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.errors import InputError, SoftBodyError

RULER = Ruler(size=1.0, by_functionals=False)


def true_error(settings: Settings) -> float:
    """Distance from the synthetic motion without errors; they are at right angles."""
    space = 0.01 * 0.25**settings.level * (0.1 if settings.elements == "smoothed" else 1.0)
    return float((settings.time_step**2 / 16.0 + space**2) ** 0.5)


@pytest.mark.parametrize("bound", [0.0012, 0.002, 0.005, 0.01])
def test_the_cheapest_that_holds(bound: float) -> None:
    """No point of the grid that holds, doubt included, is cheaper."""
    case = synthetic.CASE
    trial = Trials(case, synthetic.outcome, RULER).settle(bound)
    assert trial.error + trial.doubt <= bound
    # paths are kept in single precision; the doubt is an upper bound of what the reference errs by
    assert abs(trial.error - true_error(trial.settings)) <= trial.doubt + 1e-7
    points = [
        replace(case.default, level=level, time_step=step, elements=elements)
        for level in (0, 1)
        for step in case.time_steps
        for elements in ("linear", "smoothed")
    ]
    cheaper = [one for one in points if synthetic.outcome(one).cost < trial.cost]
    assert all(true_error(one) + 2.0 * trial.doubt > bound for one in cheaper)


@pytest.mark.parametrize("bound", [0.002, 0.0012])
def test_a_finer_mesh_sharpens_the_reference(bound: float) -> None:
    """The doubt stays above what the reference is off by, and what holds is no dearer."""
    case = replace(synthetic.CASE, meshes=((None, 0),))
    blunt = Trials(case, synthetic.outcome, RULER, most_tets=0)
    first = blunt.settle(bound)
    assert max(settings.level for settings in blunt.outcomes) == 1
    # so that the mesh's part of the doubt is more than its share of every bound
    sharp = Trials(case, synthetic.outcome, RULER, doubt=1e-3, most_tets=10**6)
    second = sharp.settle(bound)
    assert max(settings.level for settings in sharp.outcomes) == 2
    assert second.doubt < 0.5 * first.doubt and second.cost <= first.cost
    assert abs(second.error - true_error(second.settings)) <= second.doubt + 1e-7


def test_a_bound_that_nothing_holds_is_refused() -> None:
    with pytest.raises(InputError, match=r"holds 0.001% in 'cantilever'|only known to"):
        Trials(synthetic.CASE, synthetic.outcome, RULER).settle(1e-5)


def test_each_point_is_run_once() -> None:
    made: list[Settings] = []

    def run(settings: Settings) -> RunOutcome:
        made.append(settings)
        return synthetic.outcome(settings)

    trials = Trials(synthetic.CASE, run, RULER)
    trials.settle(0.01)
    trials.settle(0.002)
    assert len(made) == len(set(made)) == len(trials.outcomes)


def test_a_trial_that_fails_is_one_sentence() -> None:
    def run(settings: Settings) -> RunOutcome:
        return replace(synthetic.outcome(settings), status="numbers stopped being finite")

    with pytest.raises(SoftBodyError, match="did not end well: numbers stopped being finite"):
        Trials(synthetic.CASE, run, RULER).settle(0.01)


def test_a_controlled_scene_is_refused() -> None:
    with pytest.raises(InputError, match="'balance-i' is controlled"):
        tuned_by_trials(CASES["balance-i"], synthetic.outcome, 0.05)
