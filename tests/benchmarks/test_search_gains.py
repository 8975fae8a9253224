"""The gain search on short runs: what it draws, what a draw costs, what it writes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.gains.cases import CASES, MeasureBound, Range, at_most
from benchmarks.gains.command import cost, missing, read, search, write
from benchmarks.gains.evolution import minimise
from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError

CASE = replace(
    CASES["balance-i"],
    ranges={"position": Range(20.0, 80.0, log=True), "activation.effort": Range(0.005, 0.05)},
)


def valley(number: int, point: FloatArray) -> float:
    """A rotated, narrow parabola whose least value is 0 at (0.3, 0.6, 0.5)."""
    away = point - (0.3, 0.6, 0.5)
    return float((away[0] + away[1]) ** 2 + 100.0 * (away[0] - away[1]) ** 2 + away[2] ** 2)


def test_it_finds_a_known_minimum() -> None:
    """In 400 draws to 1e-3 of each range; drawing at random would come to some 0.1."""
    pytest.importorskip("cmaes")
    found = list(minimise(valley, np.full(3, 0.5), draws=400, seed=1))
    assert [one.number for one in found] == list(range(400))
    assert all(((one.point >= 0.0) & (one.point <= 1.0)).all() for one in found)
    best = min(found, key=lambda one: one.cost)
    np.testing.assert_allclose(best.point, (0.3, 0.6, 0.5), atol=1e-3)


def test_a_stopped_search_goes_on() -> None:
    """Wherever it was stopped it makes the same points, and asks for no cost that it knows."""
    pytest.importorskip("cmaes")
    whole = list(minimise(valley, np.full(3, 0.5), draws=40, seed=1))
    for stop in (1, 7, 23):
        known = {one.number: one.cost for one in whole[:stop]}
        asked: list[int] = []

        def again(number: int, point: FloatArray, asked: list[int] = asked) -> float:
            asked.append(number)
            return valley(number, point)

        rest = list(minimise(again, np.full(3, 0.5), draws=40, seed=1, known=known))
        assert asked == list(range(stop, 40))
        np.testing.assert_array_equal([one.point for one in rest], [one.point for one in whole])


def test_it_draws_within_the_ranges_and_begins_with_the_shipped_gains(tmp_path: Path) -> None:
    pytest.importorskip("cmaes")
    draws = list(search(CASE, draws=3, seed=4, seconds=0.1))
    assert [draw.number for draw in draws] == [0, 1, 2]
    assert dict(draws[0].gains) == CASE.shipped()
    for draw in draws:
        for name, bounds in CASE.ranges.items():
            assert bounds.low <= draw.gains[name] <= bounds.high
        assert not draw.measures["fallen"]
        # a tenth of a second is over before the push
        assert draw.measures["tilt"] < 5.0
    write(tmp_path / "draws.csv", draws)
    kept = read(tmp_path / "draws.csv", CASE)
    assert kept == draws
    # what is known is not run: a run of no length would fail
    assert list(search(CASE, draws=3, seed=4, seconds=-1.0, known=kept)) == draws
    with pytest.raises(InputError, match="draw 1 of the file is of another search of balance-i"):
        list(search(CASE, draws=3, seed=5, known=kept))


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
