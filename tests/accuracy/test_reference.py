"""The reference and the split of errors, on motions whose limits are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.accuracy import synthetic
from warp_softbody.accuracy.analysis.chart import Point, point_of, with_frontier
from warp_softbody.accuracy.analysis.design import Measured, frontier, products, useful
from warp_softbody.accuracy.analysis.motion import Ruler
from warp_softbody.accuracy.analysis.reference import Reference, reference_of
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.errors import SoftBodyError

RULER = Ruler(size=1.0, by_functionals=False)
ROUNDING = 1e-7
"""Paths are kept in single precision, at places up to 0.3 m; extrapolation triples it."""


@pytest.fixture(scope="module")
def reference() -> Reference:
    return reference_of(synthetic.CASE, synthetic.outcomes(), RULER)


def test_what_is_left_is_the_error_of_the_finest_mesh(reference: Reference) -> None:
    """Extrapolation removes an error of first order in time, and what is mixed is nothing here."""
    apart = reference.motion.path - synthetic.EXACT
    # smoothed, level 2: 0.001 / 16
    np.testing.assert_allclose(apart, np.broadcast_to((0.0, 6.25e-5, 0.0), apart.shape), atol=4e-7)
    assert reference.time_change < ROUNDING and reference.mixed_change < 4 * ROUNDING
    # level 1 to level 2: 0.001 (1/4 - 1/16)
    assert reference.mesh_change == pytest.approx(1.875e-4, abs=ROUNDING)
    assert reference.motion.functionals["tip_fall"] == pytest.approx(synthetic.FALL - 6.25e-5)


def test_errors_of_time_and_of_space_are_told_apart(reference: Reference) -> None:
    outcomes = synthetic.outcomes()
    settings = replace(synthetic.CASE.default, time_step=1.0 / 60.0)
    point = point_of(synthetic.CASE, reference, outcomes, settings)
    time, space = 0.25 / 60.0, 0.01 - 6.25e-5
    assert point.time_error == pytest.approx(time, abs=4 * ROUNDING)
    assert point.space_error == pytest.approx(space, abs=4 * ROUNDING)
    # they stand at right angles here
    assert point.error == pytest.approx(np.hypot(time, space), abs=4 * ROUNDING)


def test_without_other_time_steps_there_is_no_error_in_time(reference: Reference) -> None:
    outcomes = synthetic.outcomes()
    settings = replace(synthetic.CASE.default, tangent="exact")
    assert point_of(synthetic.CASE, reference, outcomes, settings).time_error is None


def test_a_reference_that_failed_is_not_made_up() -> None:
    outcomes = synthetic.outcomes()
    last = replace(
        next(s for s in outcomes if s.level == 2 and s.time_step == synthetic.CASE.finest[1])
    )
    outcomes[last] = replace(outcomes[last], status="numbers stopped being finite")
    with pytest.raises(SoftBodyError, match="'cantilever' did not end well: numbers stopped"):
        reference_of(synthetic.CASE, outcomes, RULER)


def test_functionals_are_compared_by_their_scales() -> None:
    ruler = Ruler(size=1.0, by_functionals=True)
    reference = reference_of(synthetic.CASE, synthetic.outcomes(), ruler)
    fine = synthetic.outcome(Settings(time_step=0.01))
    # relative to the reference's own value
    wanted = (0.25 * 0.01 + 0.01 - 6.25e-5) / (synthetic.FALL - 6.25e-5)
    assert reference.error(fine) == pytest.approx(wanted, rel=1e-5)


def measured(case_points: dict[Settings, object], reference: Reference) -> list[Measured]:
    found = []
    for settings in case_points:
        run = synthetic.outcome(settings)
        error = reference.error(run)
        assert error is not None
        found.append(Measured(settings=settings, cost=run.cost, error=error))
    return found


def test_only_knobs_that_better_the_default_are_combined(reference: Reference) -> None:
    points = measured(dict(synthetic.outcomes()), reference)
    assert useful(synthetic.CASE, points) == {"elements": ["linear", "smoothed"]}
    more = products(synthetic.CASE, points)
    assert more and all(settings.elements == "smoothed" for settings in more)
    assert not {point.settings for point in points} & set(more)
    assert len(products(replace(synthetic.CASE, products=2), points)) == 2


def test_frontier_holds_what_nothing_beats() -> None:
    def point(cost: float, error: float) -> Measured:
        return Measured(settings=Settings(time_step=cost), cost=cost, error=error)

    points = [point(3.0, 0.1), point(1.0, 0.5), point(2.0, 0.6), point(4.0, 0.099), point(5, 0.01)]
    assert [p.cost for p in frontier(points)] == [1.0, 3.0, 5]
    # what lies below the floor cannot be told from the first that reaches it
    assert [p.cost for p in frontier(points, floor=0.2)] == [1.0, 3.0]


def test_points_that_do_not_settle_or_fail_stay_off_the_frontier(reference: Reference) -> None:
    default = synthetic.CASE.default
    good = synthetic.outcome(default)
    cheap = replace(default, time_step=1.0 / 30.0)
    runs = {
        default: good,
        cheap: replace(synthetic.outcome(cheap), unconverged=0.5),
    }
    points = [Point(settings=s, outcome=run, error=reference.error(run)) for s, run in runs.items()]
    failed = replace(good, status="nodes are too far away", cost=1.0)
    points.append(Point(settings=default, outcome=failed, error=reference.error(failed)))
    chosen = [p for p in with_frontier(synthetic.CASE, points[:2], reference) if p.on_frontier]
    assert [p.settings for p in chosen] == [default]
    assert points[2].error is None and not points[2].eligible
