"""Whether settings hold on other floors than the chart's."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.accuracy.tilting import CASE, chart, outcome
from warp_softbody.accuracy.analysis.family import Family, members
from warp_softbody.accuracy.analysis.motion import MeasuredMotion, responding
from warp_softbody.accuracy.analysis.tuning import choose
from warp_softbody.accuracy.cases.case import ChartCase
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.errors import InputError

CHART = chart()
BOUND = 0.5
ROUGH = 9.0
"""Degrees by which a rough floor tilts the body, whatever it is computed with."""


class Floors:
    """Runs on other floors; on the rough one some settings tilt the body further."""

    def __init__(
        self,
        *,
        further: float,
        of: Settings | None = None,
        volume: float = 0.0,
        above: float = 0.8,
    ) -> None:
        """``further`` degrees of the settings given, of all others 0, for more friction."""
        self.further, self.of, self.volume, self.above = further, of, volume, above
        self.runs = 0

    def __call__(self, case: ChartCase, settings: Settings) -> RunOutcome:
        """A run."""
        self.runs += 1
        plain = outcome(settings)
        rough = case.given.get("friction", 0.8) > self.above
        more = rough * (ROUGH + self.further * (settings == self.of))
        tilt = plain.functionals["largest_tilt"] + more
        values = {**plain.functionals, "largest_tilt": tilt, "volume": self.volume * rough}
        return replace(plain, functionals=values)


def test_a_family_has_other_floors_and_the_end_of_the_scene() -> None:
    *floors, whole = members(CASES["balance-i"]).items()
    assert [case.given["friction"] for _, case in floors] == pytest.approx([0.64, 0.96])
    assert whole[0] == "all of its 6 s" and whole[1].seconds == 6.0 and not whole[1].given
    given = members(CASES["jump-i-in-place"])
    assert all(case.given["jumps"] == 1 for case in given.values())
    assert len(members(CASES["roll-o"])) == 2 and CASES["roll-o"].seconds == 10.0
    assert members(CASES["cantilever"]) == members(CASES["slope"]) == {}


def test_what_answers_another_floor_as_what_ships_does_errs_no_more_there() -> None:
    """Then the error on the family is that of the chart."""
    plain = choose(CHART, BOUND)
    tuned = choose(CHART, BOUND, Family(CHART, Floors(further=0.0)))
    assert tuned.settings == plain.settings
    assert plain.elsewhere is None and tuned.elsewhere == pytest.approx(tuned.error)


def test_what_errs_on_another_floor_is_passed_over_and_told() -> None:
    plain = choose(CHART, BOUND)
    floors = Floors(further=60.0, of=plain.settings)
    tuned = choose(CHART, BOUND, Family(CHART, floors))
    assert tuned.settings != plain.settings and tuned.cost > plain.cost
    shift = plain.error + 60.0 / 90.0
    assert tuned.left_out[0].endswith(f"an error of {100.0 * shift:.2g} % with friction 0.96")
    # two floors and the whole run as shipped, and the same of two candidates
    assert floors.runs == 9


def test_other_floors_may_take_a_part_of_the_bound() -> None:
    plain = choose(CHART, BOUND)
    for share, same in ((0.79, True), (0.81, False)):
        further = 90.0 * (share * BOUND - plain.error)
        floors = Floors(further=further, of=plain.settings)
        assert (choose(CHART, BOUND, Family(CHART, floors)).settings == plain.settings) is same


def test_what_does_not_keep_its_volume_elsewhere_is_passed_over() -> None:
    worst = Family(CHART, Floors(further=0.0, volume=0.04)).worst(
        next(point for point in CHART.points if point.settings != CHART.case.default)
    )
    assert worst is not None and worst.error == math.inf and worst.where == "friction 0.96"


def test_what_ships_errs_elsewhere_by_what_it_errs_by_on_the_chart() -> None:
    floors = Floors(further=0.0)
    worst = Family(CHART, floors).worst(CHART.default)
    assert worst is not None and worst.error == CHART.default.error


def test_what_ships_on_a_coarser_mesh_is_judged_by_the_usual_one() -> None:
    """Its answer to the rough floor is not the measure of itself."""
    case = replace(CASE, scene="slide-f-left")
    made = chart(case)
    assert case.default.level < 0 == case.usual.level
    assert made.default.settings == case.default
    plain = made.default.error
    for further in (0.0, 27.0):
        family = Family(made, Floors(further=further, of=case.default, above=0.1))
        worst = family.worst(made.default)
        assert plain is not None and worst is not None
        assert worst.error == pytest.approx(plain + further / 90.0)
    usual = made.of(case.usual)
    worst = Family(made, Floors(further=0.0, above=0.1)).worst(usual)
    assert worst is not None and worst.error == usual.error


def test_where_nothing_holds_elsewhere_the_least_bound_is_told() -> None:
    class Rougher(Floors):
        def __call__(self, case: ChartCase, settings: Settings) -> RunOutcome:
            self.of = None if settings == case.default else settings
            return super().__call__(case, settings)

    points = tuple(p for p in CHART.points if p.settings != CHART.case.default)
    default = replace(CHART.default, outcome=replace(CHART.default.outcome, unconverged=1.0))
    made = replace(CHART, points=(*points, default))
    with pytest.raises(InputError, match=r"hold 50% as it ships but not elsewhere: .*0\.96"):
        choose(made, BOUND, Family(made, Rougher(further=60.0)))


def test_ways_change_by_a_share_and_tilts_by_degrees() -> None:
    def motion(gone: float, tilt: float) -> MeasuredMotion:
        values = {"gone": gone, "largest_tilt": tilt}
        return MeasuredMotion(path=np.full((1, 1, 3), gone), functionals=values)

    found = responding(motion(2.0, 10.0), there=motion(0.5, 8.0), here=motion(1.0, 5.0))
    assert found.functionals == {"gone": 1.0, "largest_tilt": 13.0}
    # of nothing there is no share
    still = responding(motion(0.0, 1.0), there=motion(0.3, 1.0), here=motion(0.0, 1.0))
    assert still.functionals["gone"] == 0.3
