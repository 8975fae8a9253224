"""The measure of tuned motions on unseen runs, without its runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks import tuned_motions
from benchmarks.motions.criteria import CRITERIA
from benchmarks.robustness.outcomes import VariationOutcome
from benchmarks.tuned_costs import costs, line
from benchmarks.tuned_motions import UNSEEN, apart, cells, markdown, stored, with_settings
from warp_softbody.accuracy.analysis import store
from warp_softbody.accuracy.analysis.tuning import Tuned
from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.cases.settings import Settings
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.outcome import RunOutcome, refused


def tuned(scene: str, bound: float = 0.1) -> Tuned:
    settings = Settings(
        time_step=1.0 / 30.0, level=-1, elements="smoothed", tolerance=1e-2, qps=4, plan_cone=4
    )
    return Tuned(
        scene=scene,
        given={},
        seconds=3.5,
        bound=bound,
        settings=settings,
        error=0.02,
        uncertainty=0.03,
        cost=100.0,
        default_cost=300.0,
        default_error=0.01,
        left_out=(),
        version="0.1.0",
    )


def outcome(variation: str, way: float, *failures: str) -> VariationOutcome:
    return VariationOutcome(
        scene="slide-f",
        variation=variation,
        own=f"{way:.2f} m",
        failures=failures,
        values={"slides": way},
    )


def test_a_variation_takes_every_knob(tmp_path: Path) -> None:
    variation = with_settings(UNSEEN["friction -20 %"], tuned("slide-f"))
    assert variation.friction == 0.8 and variation.time_step == pytest.approx(2.0)
    plan = variation.plan("slide-f", tmp_path)
    simulation = variation.simulation(plan)
    assert simulation.model.tet_count == 460
    assert simulation.model.options.tolerance == 1e-2
    assert simulation.model.options.time_step == pytest.approx(1.0 / 30.0)
    assert simulation.control_options.planned_cone == 4


def test_the_least_bound_of_every_motion_is_asked(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "tuned.json"
    cantilever = replace(tuned("slide-f"), scene="cantilever")
    for one in (tuned("slide-f"), tuned("slide-f", 0.05), tuned("walk-x"), cantilever):
        store.save(one, path)
    monkeypatch.setattr(tuned_motions, "SHIPPED", path)
    found = stored()
    assert {scene: one.bound for scene, one in found.items()} == {"slide-f": 0.05, "walk-x": 0.1}
    assert len(cells(found, ["the whole run"])) == 4


def test_costs_are_medians_of_runs_in_turn() -> None:
    """The first round is a slow one; runs are no longer than they need be."""
    asked: list[Job] = []

    def run(job: Job) -> RunOutcome:
        asked.append(job)
        slow = 3.0 if len(asked) < 3 else 1.0
        shipped = job.settings == CASES["slide-f"].default
        return replace(refused(""), cost=slow * (400.0 if shipped else 150.0))

    chosen = tuned("slide-f")
    assert costs(chosen, 3, run) == (400.0, 150.0)
    assert [one.settings for one in asked[:2]] == [CASES["slide-f"].default, chosen.settings]
    assert {one.seconds for one in asked} == {2.5}
    assert line(chosen, 400.0, 150.0)[-2:] == ["2.5, 6.7", "2.7"]


OWN = {
    "exercise-h": "sway_error",
    "balance-i": "last_tilt",
    "jump-t": "turned_in_air",
    "roll-o": "rolled",
    "roll-o-return": "rolled_back",
}
"""The functional that is a scene's own number; of all others the way, or its jumps are counted."""


@pytest.mark.parametrize("scene", [scene for scene in CRITERIA if scene in CASES])
def test_tune_holds_the_own_number_of_a_scene_by_its_own_measure(scene: str) -> None:
    """A share of itself, or of its bound where it is to be small: as `moved` of fidelity has it."""
    own, name = CRITERIA[scene][0], OWN.get(scene, "gone")
    if scene == "jump-i-in-place":
        name = "take_off_speed"
    assert name in CASES[scene].functionals
    assert FUNCTIONALS[name].scale == (None if own.at_least else own.bound)


def test_what_errs_less_than_what_ships_is_not_far() -> None:
    shipped, better, worse = (
        replace(outcome("", 0.0), scene="exercise-h", values={"error": error})
        for error in (0.03, 0.01, 0.04)
    )
    assert apart(better, shipped) == 0.0
    assert apart(worse, shipped) == pytest.approx(0.1)


def test_what_is_far_or_fails_does_not_hold() -> None:
    found = {"slide-f": tuned("slide-f")}
    names = ["the whole run", "friction -20 %", "friction +20 %", "turned world"]
    made = [outcome(name, 2.5) for name in names[:3]]
    made += [outcome("the whole run, tuned", 2.6), outcome("friction -20 %, tuned", 3.0)]
    made += [outcome("friction +20 %, tuned", 2.5, "tilt 40 degrees")]
    by_name = {(one.scene, one.variation): one for one in made}
    assert apart(made[3], made[0]) == pytest.approx(0.04)
    text = markdown(by_name, found, names)
    assert "| 2.50 m, 2.60 m | **2.50 m, 3.00 m** |" in text
    assert "2.50 m, 2.50 m, **tilt 40 degrees** | not run |" in text
    assert text.endswith("1 of 3 hold.")
