"""What a controller planned for its patches, in the stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_softbody import ContactMode, Simulation, StageWriter, scenes
from warp_softbody.stage_exports import read_take


def test_plan_of_a_standing_letter(tmp_path: Path) -> None:
    """Four patches that bear the weight, but for what the plan leaves to the next step.

    To the plan a patch is the mean of its nodes, and the base may bend between them: it bears
    96 % of the weight. In the step every node bears its own, and all of it.
    """
    plan = scenes.make("balance-i", {"push": 0.0})
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step, fps=30.0)
    with StageWriter(tmp_path / "take.usdc", plan.scene, fps=30.0) as stage:
        for frame in simulation.run(1.0):
            stage.write(frame)
    take = read_take(tmp_path / "take.usdc")
    assert len(take.patches[0].points) == 0
    last = take.patches[-1]
    assert last.points.shape == (4, 3)
    assert (last.modes != ContactMode.LIFT).all()
    weight = simulation.model.masses.sum() * 9.81
    np.testing.assert_allclose(last.forces.sum(axis=0), [0.0, 0.0, weight], atol=0.1 * weight)
    # where the base stands: under the character, on the ground
    np.testing.assert_allclose(last.points.mean(axis=0), 0.0, atol=0.01)


def test_passive_bodies_have_none(tmp_path: Path) -> None:
    plan = scenes.make("drop-block")
    with StageWriter(tmp_path / "take.usdc", plan.scene) as stage:
        stage.write(next(Simulation(plan.scene, time_step=0.01).run(0.1)))
    assert [len(sample.points) for sample in read_take(tmp_path / "take.usdc").patches] == [0]
