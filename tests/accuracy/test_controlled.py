"""References of controlled scenes, which have no limit, and what may be promised of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.accuracy.tilting import (
    CASE,
    MESH_DOES,
    RULER,
    STEP_DOES,
    TILT,
    chart,
    outcome,
    outcomes,
)
from warp_softbody.accuracy.analysis.design import reference_family, useful
from warp_softbody.accuracy.analysis.motion import MeasuredMotion
from warp_softbody.accuracy.analysis.reference import Reference, reference_of
from warp_softbody.accuracy.analysis.tuning import choose, margin
from warp_softbody.accuracy.cases.case import ChartCase
from warp_softbody.accuracy.cases.letter_rows import LETTERS
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.errors import InputError, SoftBodyError


def test_the_reference_is_a_run_and_nothing_is_extrapolated() -> None:
    """90 degrees are the scale of tilts; the last halving on the own mesh is 1/240 s."""
    reference: Reference = reference_of(CASE, outcomes(), RULER)
    assert reference.motion.functionals["largest_tilt"] == pytest.approx(TILT + 2.0 * STEP_DOES)
    assert reference.mesh_change == pytest.approx(MESH_DOES / 90.0)
    assert reference.time_change == pytest.approx(STEP_DOES / 90.0)
    assert reference.mixed_change == 0.0
    assert reference.uncertainty == pytest.approx((MESH_DOES + STEP_DOES) / 90.0)


def test_a_reference_is_in_doubt_by_what_one_number_is() -> None:
    """The mesh moves the tilt, the step moves the time; neither moves both."""
    runs = outcomes()
    beside = reference_of(CASE, runs, RULER).beside
    later = {**runs[beside].functionals, "upright_again": 2.5}
    runs[beside] = replace(runs[beside], functionals=later)
    reference = reference_of(CASE, runs, RULER)
    assert reference.mesh_change == pytest.approx(MESH_DOES / 90.0)
    assert reference.time_change == pytest.approx(0.2)
    assert (
        reference.uncertainty == pytest.approx(0.2) == max(reference.to_dict()["doubts"].values())
    )


@pytest.mark.parametrize("case", LETTERS, ids=lambda case: case.scene)
def test_three_runs_make_a_reference(case: ChartCase) -> None:
    """No more, as the refined mesh is what costs; and all that is needed."""
    for chosen in (case, case.quickly()):
        family = reference_family(chosen)
        reference_of(chosen, {one: outcome_of(case) for one in family}, RULER)
        assert chosen.beside[1] == pytest.approx(0.5 * chosen.finest[1])
    family = reference_family(case)
    assert len(family) == 3
    assert sum(one.mesh == case.finest[0] for one in family) == 1


def outcome_of(case: ChartCase) -> RunOutcome:
    values = dict.fromkeys(case.functionals, 1.0)
    return replace(outcome(case.default), functionals=values)


def test_tune_promises_what_the_reference_allows_and_no_less() -> None:
    made = chart()
    floor = (MESH_DOES + STEP_DOES) / 90.0
    # the best point has the step of the reference, and is off by the mesh
    halved, best = replace(CASE.default, time_step=1.0 / 120.0), MESH_DOES / 90.0
    least = (best + floor) / margin(CASE)
    assert choose(made, 1.0001 * least).settings == halved
    with pytest.raises(InputError, match=r"the reference is only known to 6\.3%") as refused:
        choose(made, 0.9999 * least)
    # what the sentence names is held
    told = float(str(refused.value).rpartition(" is ")[2].rstrip("%")) / 100.0
    held = choose(made, told)
    assert least <= told < 1.1 * least and held.error + floor <= told
    # a wide bound is held by something cheaper than what is shipped
    loose = choose(made, 0.5)
    assert loose.cost < loose.default_cost and loose.uncertainty == pytest.approx(floor)


def test_nothing_of_nothing_is_no_error() -> None:
    """Heights may be exactly 0, of what is compared or of what it is compared with."""
    case = CASES["crawl-i-inchworm"]
    flat, arched = (
        MeasuredMotion(
            path=np.zeros((1, 1, 3)), functionals={**outcome_of(case).functionals, "arch": h}
        )
        for h in (0.0, 0.2)
    )
    assert RULER.distance(flat, flat) == 0.0
    assert RULER.distance(flat, arched) == 1.0
    assert RULER.distance(arched, flat) == np.inf
    runs = {one: outcome_of(case) for one in reference_family(case)}
    finest = next(one for one in runs if one.level)
    values = {**runs[finest].functionals, "arch": 0.0}
    runs[finest] = replace(runs[finest], functionals=values)
    with pytest.raises(SoftBodyError, match="'crawl-i-inchworm' has a functional that is 0"):
        reference_of(case, runs, RULER)


def test_dear_values_are_not_combined() -> None:
    """A looser solve saves cost; a refined mesh that errs less costs more than the case's reach."""
    from warp_softbody.accuracy.analysis.design import Measured

    measured = [
        Measured(settings=one.settings, cost=one.outcome.cost, error=one.error or 0.0)
        for one in chart().points
    ]
    assert useful(CASE, measured) == {"tolerance": [None, 1e-2]}
