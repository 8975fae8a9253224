"""Which point is taken for a bound."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.accuracy import synthetic
from warp_softbody import scenes
from warp_softbody.accuracy.analysis import store
from warp_softbody.accuracy.analysis.chart import Chart, Point
from warp_softbody.accuracy.analysis.motion import Ruler
from warp_softbody.accuracy.analysis.reference import reference_of
from warp_softbody.accuracy.analysis.tuning import MARGIN, choose
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.errors import InputError

DEFAULT = synthetic.CASE.default
REFERENCE = reference_of(
    synthetic.CASE, synthetic.outcomes(), Ruler(size=1.0, by_functionals=False)
)


def chart(*points: tuple[Settings, float, float]) -> Chart:
    """Of settings with their cost and error; all of them on the frontier."""
    made = [
        Point(
            settings=settings,
            outcome=replace(synthetic.outcome(settings), cost=cost),
            error=error,
            on_frontier=True,
        )
        for settings, cost, error in points
    ]
    return Chart(case=synthetic.CASE, reference=REFERENCE, points=tuple(made))


FINE = replace(DEFAULT, time_step=1.0 / 240.0)
SMOOTH = replace(DEFAULT, elements="smoothed")
BOTH = replace(SMOOTH, tolerance=1e-2)


def test_the_cheapest_that_holds_the_bound_with_the_margin() -> None:
    made = chart((DEFAULT, 10.0, 0.1), (SMOOTH, 20.0, 0.03), (FINE, 40.0, 0.01))
    floor = REFERENCE.uncertainty
    assert choose(made, 0.2).settings == DEFAULT
    # the reference's own doubt counts, and a fifth of the bound is kept
    assert choose(made, 1.0001 * (0.03 + floor) / MARGIN).settings == SMOOTH
    tuned = choose(made, 0.9999 * (0.03 + floor) / MARGIN)
    assert (tuned.settings, tuned.cost, tuned.default_cost) == (FINE, 40.0, 10.0)
    assert any("but an error of 3 %" in line for line in tuned.left_out)
    assert any("not needed" in line for line in choose(made, 0.2).left_out)


def test_of_costs_that_are_alike_the_plainest() -> None:
    made = chart((BOTH, 19.0, 0.03), (SMOOTH, 20.0, 0.035), (DEFAULT, 30.0, 0.1))
    assert choose(made, 0.1).settings == SMOOTH
    made = chart((BOTH, 15.0, 0.03), (SMOOTH, 20.0, 0.035), (DEFAULT, 30.0, 0.1))
    assert choose(made, 0.1).settings == BOTH


def test_a_bound_that_nothing_holds_is_refused() -> None:
    made = chart((DEFAULT, 10.0, 0.1), (SMOOTH, 20.0, 0.03))
    with pytest.raises(InputError, match="the best point is off by 3%"):
        choose(made, 0.01)


def test_the_least_bound_told_is_that_of_every_point_but_the_references_own() -> None:
    """Also of a point that is not on the frontier, as it is below what can be told apart."""
    finest = REFERENCE.finest
    made = chart((DEFAULT, 10.0, 0.1), (SMOOTH, 20.0, 0.03), (finest, 90.0, 0.0))
    points = [replace(p, on_frontier=p.settings == DEFAULT) for p in made.points]
    made = replace(made, points=tuple(points))
    with pytest.raises(InputError, match="the best point is off by 3%"):
        choose(made, 0.01)
    nothing = replace(made, points=(replace(made.points[0], error=None), made.points[2]))
    with pytest.raises(InputError, match="the best point is off by inf%"):
        choose(nothing, 0.01)


def test_what_ships_can_be_run() -> None:
    shipped = store.load(store.SHIPPED)
    assert shipped
    for tuned in shipped:
        assert tuned.scene in CASES and tuned.settings.possible
        margin = 1.0 if CASES[tuned.scene].controlled else MARGIN
        assert tuned.error + tuned.uncertainty <= margin * tuned.bound
        plan = tuned.settings.plan(tuned.scene, tuned.given)
        assert plan.name == scenes.recipe(tuned.scene).name
