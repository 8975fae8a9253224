"""The gain search on short runs: what it draws, what a draw costs, what it writes."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.gains.cases import CASES, MeasureBound, Range, at_most
from benchmarks.gains.command import cost, missing, search, write

CASE = replace(
    CASES["balance-i"],
    ranges={"position": Range(20.0, 80.0, log=True), "activation.effort": Range(0.005, 0.05)},
)


def test_it_draws_within_the_ranges_and_begins_with_the_shipped_gains(tmp_path: Path) -> None:
    draws = search(CASE, draws=3, seed=4, seconds=0.1)
    assert [draw.cost for draw in draws] == sorted(draw.cost for draw in draws)
    by_number = {draw.number: draw for draw in draws}
    assert dict(by_number[0].gains) == CASE.shipped()
    for draw in draws:
        for name, bounds in CASE.ranges.items():
            assert bounds.low <= draw.gains[name] <= bounds.high
        assert not draw.measures["fallen"]
        # a tenth of a second is over before the push
        assert draw.measures["tilt"] < 5.0
    again = search(CASE, draws=3, seed=4, seconds=0.1)
    assert [draw.gains for draw in again] == [draw.gains for draw in draws]
    write(tmp_path / "draws.csv", draws)
    with (tmp_path / "draws.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["position"]) for row in rows] == [draw.gains["position"] for draw in draws]


def test_a_goal_costs_what_is_missing_to_it_with_its_margin() -> None:
    # 0.25 with a tenth more is 0.275
    goal = MeasureBound("way", 0.25)
    assert missing(goal, {"way": 0.22}, 0.1) == pytest.approx(0.055 / 0.275)
    assert missing(goal, {"way": 0.3}, 0.1) == 0.0
    assert missing(at_most("tilt", 5.0), {"tilt": 90.0}, 0.0) == 1.0
    case = replace(CASE, goals=(goal,))
    measures = {"way": 0.0, "sign_changes": 0.1, "fallen": 0.0, "seconds": 2.0}
    assert cost(case, measures, 0.0) == pytest.approx(1.0 + 1e-4)
    assert cost(case, {**measures, "fallen": 1.0}, 0.0) == pytest.approx(1.0 - 0.002 + 1e-4)
