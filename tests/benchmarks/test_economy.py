"""The benchmark of what is not spent; its times are those of this machine now."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks import economy
from warp_softbody.engine.stepper import Stepper
from warp_softbody.scenes.balance_i import balancing_letter
from warp_softbody.world.scene import Scene


def test_a_sleeping_step_costs_next_to_nothing() -> None:
    """Below 2 % of a moving one; a sleeping step touches no kernel, so there is room."""
    assert economy.at_rest("drop-block", steps=10, seconds=10.0) < 0.02


def test_a_build_without_muscles_does_the_same() -> None:
    """What it leaves out is never launched, so the motions are equal to the last bit."""
    bare = Scene(character=replace(balancing_letter(), muscles=()))
    ends = []
    for stepper in (Stepper, economy.WithoutMuscles):
        simulation = economy.of_scene(bare, stepper)
        for _ in range(3):
            simulation.step()
        ends.append(simulation.view().positions)
    np.testing.assert_array_equal(ends[0], ends[1])


def test_ratios_are_of_the_same_steps() -> None:
    """A preconditioner that is never kept costs more, whatever the machine does."""
    assert economy.restless("cantilever").model.system.coarse is None
    found = economy.ratio(
        lambda: economy.plain("cantilever"), lambda: economy.restless("cantilever"), steps=40
    )
    assert found < 1.0


def test_modes_that_hold_are_counted() -> None:
    kept, few, mean = economy.qps("balance-i", 0.2)
    assert 0.0 <= kept <= 1.0
    assert 0.0 < few <= 16.0
    assert 0.0 < mean <= 16.0
