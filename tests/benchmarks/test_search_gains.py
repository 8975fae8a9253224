"""The gain search: what it draws, what a draw costs, when it is given up, and how it goes on."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import ParamSpec, TypeVar

import numpy as np
import pytest

from benchmarks.gains import search as searching
from benchmarks.gains.cases import CASES
from benchmarks.gains.command import line, write
from benchmarks.gains.family import family
from benchmarks.gains.journal import TrialJournal
from benchmarks.gains.search import Draw, FamilySearch
from benchmarks.gains.trials import Fall, Trial, family_cost, make_trials, missing, trial_cost
from benchmarks.motions.criteria import CRITERIA, SOUND
from benchmarks.motions.criterion import Criterion, below
from benchmarks.robustness.outcomes import Cell
from benchmarks.robustness.runs import run
from benchmarks.robustness.variation import Variation
from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.run.simulation import Simulation
from warp_softbody.teaching.evolution import minimise
from warp_softbody.teaching.ranges import Range

P = ParamSpec("P")
T = TypeVar("T")
RANGES = {"position": Range(2.0, 8.0, log=True), "activation.effort": Range(0.005, 0.05)}
CASE = replace(CASES["balance-i"], ranges=RANGES)
MEMBERS = family("balance-i", ["as shipped", "dt x 2", "push=0.5"])
BOUNDS = {one.name: one for one in (*CRITERIA["balance-i"], *SOUND)}


class AtOnce(Executor):
    """Makes every call when it is handed in."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return what is done already."""
        done: Future[T] = Future()
        done.set_result(fn(*args, **kwargs))
        return done


def each(
    cost: Callable[[FloatArray], float],
) -> Callable[[Mapping[int, FloatArray]], dict[int, float]]:
    """Costs of a generation from the cost of a point."""
    return lambda points: {number: cost(point) for number, point in points.items()}


def valley(point: FloatArray) -> float:
    """A rotated, narrow parabola whose least value is 0 at (0.3, 0.6, 0.5)."""
    away = point - (0.3, 0.6, 0.5)
    return float((away[0] + away[1]) ** 2 + 100.0 * (away[0] - away[1]) ** 2 + away[2] ** 2)


def test_it_finds_a_known_minimum() -> None:
    """In 400 draws to 1e-3 of each range; drawing at random would come to some 0.1."""
    pytest.importorskip("cmaes")
    found = list(minimise(each(valley), np.full(3, 0.5), draws=400, seed=1))
    assert [one.number for one in found] == list(range(400))
    assert all(((one.point >= 0.0) & (one.point <= 1.0)).all() for one in found)
    best = min(found, key=lambda one: one.cost)
    np.testing.assert_allclose(best.point, (0.3, 0.6, 0.5), atol=1e-3)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, str]]:
    """Runs made up: only `dt x 2` falls, the sooner the further the gain is from 4."""
    pytest.importorskip("cmaes")
    asked: list[tuple[float, str]] = []

    def made(
        scene: str,
        candidates: Sequence[Mapping[str, float]],
        member: Variation,
        seconds: object,
        meshes: object,
    ) -> list[Trial]:
        return [one(gains, member) for gains in candidates]

    def one(gains: Mapping[str, float], member: Variation) -> Trial:
        asked.append((gains["position"], member.name))
        if member.name == "dt x 2":
            return Trial(values={}, lasted=6.0 - abs(gains["position"] - 4.0) / 2.0)
        return Trial(values={name: one.bound for name, one in BOUNDS.items()}, lasted=6.0)

    monkeypatch.setattr(searching, "make_trials", made)
    return asked


def looked(journal: Path | None = None, *, seed: int = 4, draws: int = 25) -> list[Draw]:
    search = FamilySearch(
        case=CASE, members=MEMBERS, journal=TrialJournal(journal), executor=AtOnce()
    )
    return list(search.run(draws, seed))


def test_a_draw_that_is_worse_than_the_best_is_given_up(asked: list[tuple[float, str]]) -> None:
    """By the member that was worst before, which is asked first."""
    draws = looked()
    assert draws[0].gains == CASE.shipped()
    assert draws[0].whole
    for draw in draws[1:]:
        for name, bounds in RANGES.items():
            assert bounds.low <= draw.gains[name] <= bounds.high
        # the shipped one was worst there, and so is every other one
        assert next(iter(draw.costs)) == "dt x 2"
        assert draw.worst == "dt x 2"
        assert draw.whole or draw.cost > min(other.cost for other in draws[: draw.number])
    assert any(not draw.whole for draw in draws)
    assert len(asked) == sum(len(draw.costs) for draw in draws)
    # of all draws the one with the gain nearest to 4 is best, and was run in every member
    best = min(draws, key=lambda draw: draw.cost)
    assert best.whole
    assert abs(best.gains["position"] - 4.0) == min(abs(d.gains["position"] - 4.0) for d in draws)


def test_a_stopped_search_goes_on(asked: list[tuple[float, str]], tmp_path: Path) -> None:
    """Wherever its journal was torn it makes the same draws, and only the runs that it lacks."""
    journal = tmp_path / "runs.jsonl"
    whole = looked(journal)
    lines, runs = journal.read_text().splitlines(keepends=True), len(asked)
    assert len(lines) == runs
    for kept in (0, 2, 11):
        journal.write_text("".join(lines[:kept]) + lines[kept][:30])
        asked.clear()
        assert looked(journal) == whole
        assert len(asked) == runs - kept
    asked.clear()
    assert looked(journal) == whole
    assert asked == []
    # other gains are other runs, but the shipped ones
    looked(journal, seed=5)
    assert len(asked) > 0
    assert all(gain != CASE.shipped()["position"] for gain, _ in asked)


def test_the_table_has_every_draw(asked: list[tuple[float, str]], tmp_path: Path) -> None:
    draws = looked(draws=9)
    names = [member.name for member in MEMBERS]
    write(tmp_path / "draws.csv", draws, names)
    with (tmp_path / "draws.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["number", "cost", "worst", *RANGES, *names]
    for row, draw in zip(rows, draws, strict=True):
        assert float(row["position"]) == draw.gains["position"]
        assert [name for name in names if row[name]] == [n for n in names if n in draw.costs]
    assert "dt x 2: falls after" in line("balance-i", draws[0])


def test_a_bound_costs_what_is_missing_to_it_with_its_margin() -> None:
    # 0.25 with a tenth more is 0.275
    way = Criterion("ahead", lambda m: 0.0, 0.25)
    assert missing(way, 0.25, 0.22, 0.1) == pytest.approx(0.055 / 0.275)
    assert missing(way, 0.25, 0.3, 0.1) == 0.0
    tilt = below("tilt", lambda m: 0.0, 5.0)
    assert missing(tilt, 5.0, 90.0, 0.0) == 1.0
    assert missing(tilt, 5.0, float("inf"), 0.0) == 1.0
    assert missing(tilt, 3.0, 4.0, 0.0) == pytest.approx(1.0 / 3.0)


def test_a_fall_costs_more_than_any_run_that_stands() -> None:
    bad = {name: np.inf if not one.at_least else -np.inf for name, one in BOUNDS.items()}
    late, early = Trial(values={}, lasted=5.0), Trial(values={}, lasted=1.0)
    good = {name: 0.0 if not one.at_least else 2.0 * one.bound for name, one in BOUNDS.items()}
    costs = [trial_cost(CASE, trial, 0.1) for trial in (Trial(values=good), late, early)]
    assert costs[0] == 0.0
    assert trial_cost(CASE, Trial(values=bad), 0.1) == pytest.approx(len(BOUNDS), rel=1e-2)
    assert 1.1 * len(BOUNDS) < costs[1] < costs[2] < 2.0 * len(BOUNDS)


def test_a_family_costs_at_least_what_its_members_so_far_do() -> None:
    costs = [0.3, 0.0, 0.9, 0.2]
    so_far = [family_cost(costs[:k], 4) for k in range(5)]
    assert so_far == sorted(so_far)
    assert so_far[-1] == pytest.approx((0.9 + 0.1 * np.mean(costs)) / 1.1)
    assert family_cost([0.5] * 4, 4) == pytest.approx(0.5)


def test_members_join_variations_and_settings() -> None:
    (one,) = family("balance-i", ["dt / 2 + half the step + push=0.5 + side=135 + side=-45"])
    assert one.time_step == 0.25
    assert one.settings == {"push": 0.5}
    assert one.side == 90.0
    for wrong, message in (
        (["dt/2"], "'dt/2' is no member of a family of balance-i"),
        (["push=3"], "setting 'push' must be"),
        (["side=left"], "'side=left' is no number of degrees"),
        (["as shipped", "as shipped"], "each one once"),
        ([], "at least one member"),
    ):
        with pytest.raises(InputError, match=message):
            family("balance-i", wrong)


def test_candidates_are_run_together_with_their_gains(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tenth of a second is over before the push; pushes are turned, gains and settings set."""
    seen: list[Simulation] = []
    build = Simulation.__init__

    def kept(self: Simulation, *given: object, **named: object) -> None:
        build(self, *given, **named)  # type: ignore[arg-type]
        seen.append(self)

    monkeypatch.setattr(Simulation, "__init__", kept)
    (member,) = family("balance-i", ["push=0.4 + side=90 + dt x 2"])
    softer = {**CASE.shipped(), "material.young_modulus": 6e5}
    both = make_trials("balance-i", [softer, CASE.shipped()], member, 0.1, tmp_path)
    simulation, other = seen
    for trial in both:
        assert set(trial.values) == set(BOUNDS)
        assert trial.lasted == pytest.approx(0.1)
    (push,) = simulation.model.scene.pushes
    weight = 9.81 * simulation.model.masses.sum()
    np.testing.assert_allclose(push.force, (0.0, 0.4 * weight, 0.0), rtol=1e-3, atol=1e-9)
    assert simulation.model.scene.character.material.young_modulus == 6e5
    assert simulation.model.options.time_step == pytest.approx(1.0 / 30.0)
    assert other.model.scene.character.material.young_modulus != 6e5
    # as if each were run alone
    cell = Cell(scene="balance-i", variation=member, seconds=0.1)
    alone = run(cell, tmp_path, make=lambda _, settings: CASE.plan(softer, settings))
    assert alone.values == both[0].values


def test_a_candidate_that_is_refused_leaves_the_others(
    tmp_path: Path,
) -> None:
    (member,) = family("balance-i", ["as shipped"])
    wrong = {**CASE.shipped(), "material.young_modulus": -1.0}
    refused, made = make_trials("balance-i", [wrong, CASE.shipped()], member, 0.05, tmp_path)
    assert refused == Trial(values={})
    assert set(made.values) == set(BOUNDS)


def test_a_body_that_lies_ends_its_run() -> None:
    pytest.importorskip("cmaes")
    plan = CASE.plan({}, {})
    frames = list(Simulation(plan.scene, None, time_step=1.0 / 60.0).run(0.05))
    lying = replace(frames[-1], positions=0.5 * frames[-1].positions)
    fall = Fall(stands=True)
    assert not any(fall(frame) for frame in frames)
    assert fall(lying)
    assert fall.time == lying.time
    assert not Fall(stands=False)(lying)
