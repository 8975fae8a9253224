"""The benchmark of what is not spent compares what it says; its times are not judged here."""

from __future__ import annotations

import numpy as np

from benchmarks import economy

STEPS = 40


def test_a_sleeping_step_does_nothing() -> None:
    """What is timed as a sleeping step is counted as left out, and moves no node."""
    simulation = economy.plain("drop-block")
    while not simulation.asleep:
        simulation.step()
    before, slept = simulation.state.positions.numpy(), simulation.summary().slept_steps
    simulation.step()
    assert simulation.summary().slept_steps == slept + 1
    np.testing.assert_array_equal(simulation.state.positions.numpy(), before)
    assert 0.0 < economy.at_rest("drop-block", steps=5, seconds=10.0) < np.inf


def test_ratios_are_of_what_they_say() -> None:
    """A restless preconditioner is made anew in every step, a kept one is not."""
    sides = economy.plain("cantilever"), economy.restless("cantilever")
    assert sides[1].model.system.coarse is None
    assert 0.0 < economy.ratio(lambda: sides[0], lambda: sides[1], steps=STEPS) < np.inf
    kept, anew = (side.summary().renewals for side in sides)
    assert kept < 0.5 * STEPS
    assert anew >= STEPS


def test_modes_that_hold_are_counted() -> None:
    kept, few, mean = economy.qps("balance-i", 0.2)
    assert 0.0 <= kept <= 1.0
    assert 0.0 < few <= 16.0
    assert 0.0 < mean <= 16.0
