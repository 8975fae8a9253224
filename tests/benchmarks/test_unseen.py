"""The measure of tuned settings on other scenes, without its runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.charts import unseen
from benchmarks.charts.unseen import BOUNDS, VARIANTS, UnseenChoice, Variant
from tests.accuracy import synthetic
from warp_softbody import scenes
from warp_softbody.accuracy.cases.table import CASES
from warp_softbody.accuracy.runs.job import Job
from warp_softbody.accuracy.runs.outcome import RunOutcome


def test_every_variant_is_a_scene_with_a_setting_changed() -> None:
    for name, variants in VARIANTS.items():
        plain = scenes.make(name, CASES[name].given).settings
        for given in variants:
            changed = scenes.make(name, {**CASES[name].given, **given}).settings
            assert {key for key in changed if changed[key] != plain[key]} == set(given)


def test_verdicts_count_what_holds_and_what_it_costs() -> None:
    good = UnseenChoice(bound=0.02, error=0.01, ratio=1.0)
    dear = UnseenChoice(bound=0.02, error=0.01, ratio=2.0)
    missed = UnseenChoice(bound=0.02, error=0.03, ratio=0.5)
    refused = UnseenChoice(bound=0.02, error=None, ratio=None)
    told = unseen.totals("tried", [good, dear, missed, refused])
    assert "2 of 3 offered hold, 1 not offered" in told and "above 1.3 in 1 of 2" in told


def test_the_cheapest_known_point_is_what_costs_are_over(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """On synthetic motions, which know nothing of the scene's settings."""

    def run(job: Job) -> RunOutcome:
        return synthetic.outcome(job.settings)

    small = replace(synthetic.CASE, quick={"meshes": ((None, 0), (None, 1))})
    monkeypatch.setitem(CASES, "cantilever", small)
    monkeypatch.setattr(unseen, "run_job", run)
    variant = Variant("cantilever", {"young_modulus": 5e5}, tmp_path)
    verdict = variant.verdict("tried", BOUNDS[1])
    assert verdict.held and verdict.ratio is not None and verdict.ratio >= 1.0
    assert "cantilever" in unseen.line("cantilever", variant, "tried", [verdict])
    # from the journal
    monkeypatch.setattr(unseen, "run_job", None)
    assert Variant("cantilever", {"young_modulus": 5e5}, tmp_path).verdict("tried", 0.02) == verdict
