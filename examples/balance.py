"""A letter I is pushed at its head and keeps its balance: the README's script."""

from __future__ import annotations

from pathlib import Path

import warp_softbody as wsb
from warp_softbody.run.run_summary import RunSummary


def main(path: str | Path = "balance.usdc", seconds: float = 6.0) -> RunSummary:
    """Simulate, write the stage and return the run in numbers."""
    character = wsb.characters.letter_i()
    push = wsb.Push(region="head", force=(300.0, 0.0, 0.0), start=0.5, duration=0.2)
    scene = wsb.Scene(character=character, ground=wsb.Plane(friction=0.8), pushes=(push,))
    simulation = wsb.Simulation(scene, controller=wsb.controllers.Balance(), time_step=1 / 60)
    with wsb.StageWriter(path, scene, fps=30) as stage:
        for frame in simulation.run(seconds):
            stage.write(frame)
    return simulation.summary()


if __name__ == "__main__":
    print(main())
