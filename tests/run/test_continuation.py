"""A simulation that goes on after another one, as it was or under something else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import warp_softbody as wsb
from warp_softbody.errors import InputError


def falling(name: str = "drop-block", seconds: float = 0.2) -> wsb.Simulation:
    plan = wsb.scenes.make(name)
    simulation = wsb.Simulation(plan.scene, time_step=plan.time_step)
    for _ in simulation.run(seconds):
        pass
    return simulation


@pytest.mark.parametrize("name", ["drop-block", "stack", "topple-i"])
def test_it_goes_on_as_the_other_one_would(name: str) -> None:
    """Up to what solves leave over, as they start from other places.

    Within an impact a rounding decides which node touches first, so they part after it.
    """
    first = falling(name, seconds=0.35)
    options = first.model.options
    second = wsb.Simulation(first.model.scene, options=options, after=first)
    assert second.time == first.time
    for _ in range(10):
        first.step()
        second.step()
    size = np.ptp(first.frame().positions, axis=0).max()
    gap = np.abs(first.frame().positions - second.frame().positions).max()
    assert gap < options.solver_tolerance * size


def test_gravity_is_changed_on_the_way() -> None:
    """Of a body in the air: what its speed gains is the new gravity times the time."""
    first = falling(seconds=0.05)
    scene = replace(first.model.scene, gravity=(0.0, 0.0, 1.0))
    second = wsb.Simulation(scene, options=first.model.options, after=first)
    before = second.frame().velocities
    second.step()
    gained = second.model.masses @ (second.frame().velocities - before)
    expected = second.model.masses.sum() * second.model.options.time_step
    np.testing.assert_allclose(gained, (0.0, 0.0, expected), atol=1e-4 * expected)


def test_what_does_not_fit_is_refused() -> None:
    first = falling()
    other = wsb.scenes.make("stack")
    with pytest.raises(InputError, match="same bodies and muscles"):
        wsb.Simulation(other.scene, options=first.model.options, after=first)
    with pytest.raises(InputError, match="after of a Simulation must have the same time_step"):
        wsb.Simulation(first.model.scene, time_step=1e-3, after=first)
    with pytest.raises(InputError, match="after of a Simulation must be"):
        wsb.Simulation(first.model.scene, after="before")  # type: ignore[arg-type]
