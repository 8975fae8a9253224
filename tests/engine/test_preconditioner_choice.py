"""Which preconditioner "auto" takes: a whole factor where it has few blocks, more with muscles."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.support.bodies import box, straight_fiber
from warp_softbody import Character, MuscleGroup, Scene, build_model
from warp_softbody.engine.options import SimulationOptions

MUSCLE = MuscleGroup(
    name="m",
    fibers=(straight_fiber("f", (0.1, 0.1, 0.02), (0.1, 0.1, 0.18), 4),),
    strength=1e5,
    kernel_width=0.05,
)


@pytest.mark.parametrize(
    ("cells", "muscled", "levels"),
    [(5, False, 1), (7, False, 2), (7, True, 1), (10, True, 2)],
)
def test_muscles_are_worth_a_larger_factor(cells: int, muscled: bool, levels: int) -> None:
    cube = Character(name="cube", mesh=box((cells,) * 3))
    if muscled:
        cube = replace(cube, muscles=(MUSCLE,))
    model = build_model(Scene(character=cube), SimulationOptions())
    assert (model.system.coarse is not None) == (levels == 2)
