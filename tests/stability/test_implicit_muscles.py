"""The cases of strong muscles with implicit ones, which come to rest."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import pytest

from benchmarks.stability import bodies, catalogue
from benchmarks.stability.cases import StabilityCase
from benchmarks.stability.movers import OurBody
from benchmarks.stability.runs import run
from benchmarks.stability.starts import at_rest

CASES = {case.name: case for case in catalogue.muscles()}


def longest_step(case: StabilityCase) -> StabilityCase:
    """A free bar of strength 10 E without damping, at 0.5 s."""
    make = partial(bodies.muscular_bar, 2e6, damped=False)
    setting = replace(case.setting, make=make, time_step=0.5, pulled=20, steps=60)
    return replace(case, setting=setting)


CASES["strong undamped dt 0.5"] = longest_step(CASES["muscles strong undamped"])
SUBJECTS = ("muscles dt 0.5", "muscles strong undamped", "strong undamped dt 0.5")


@pytest.mark.parametrize("iterations", [1, 2, 3])
@pytest.mark.parametrize("name", SUBJECTS)
def test_slack_to_full_and_back_comes_to_rest(name: str, iterations: int) -> None:
    """What is full of muscle stores at most the elastic energy of its full contraction.

    A body at rest that is let go has none but what muscles do; its peak is that of statics, the
    energy of the first rest under tension, so that a tenth above it is an overshoot.
    """
    setting = CASES[name].setting
    options = {"muscles": "implicit", "newton_iterations": iterations}
    found = run(setting, OurBody(setting, at_rest, options))
    assert found.stopped is None and found.overlooked is None
    assert found.inverted == 0
    assert abs(found.volume - 1.0) < 0.01
    assert found.shape < 0.01
    still = replace(setting, pulled=setting.steps)
    held = OurBody(still, at_rest, options)
    run(still, held)
    assert found.peak <= 1.1 * held.sample().energy
