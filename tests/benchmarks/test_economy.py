"""The benchmark of what is not spent; its times are those of this machine now."""

from __future__ import annotations

from benchmarks import economy


def test_a_sleeping_step_costs_next_to_nothing() -> None:
    """Below 2 % of a moving one; a sleeping step touches no kernel, so there is room."""
    assert economy.at_rest("drop-block", steps=10, seconds=10.0) < 0.02


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
