"""How many perturbed starts a motion survives: `python -m benchmarks.perturbed_starts cartwheel-x`.

Start k has random numbers of its own: friction and stiffness by up to a fifth more or less, a body
that is turned by up to two degrees about each axis and stands on its lowest point, and a push of
0.02 body weights at the head, for 0.2 s, in any horizontal direction at any time. It is survived
where the scene's own criteria are met (`benchmarks.motions.criteria`).
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.gains.cases import changed_character
from benchmarks.motions.criteria import CRITERIA
from benchmarks.motions.criterion import RecordedMotion
from warp_softbody import scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes import ScenePlan
from warp_softbody.stage_exports import StageWriter
from warp_softbody.world.refined_scene import refined_scene
from warp_softbody.world.scene import STANDARD_GRAVITY, Push

FACTOR = 0.2
TILT = 2.0  # degrees
PUSH = 0.02  # body weights
PUSH_SECONDS = 0.2


class PerturbedStart(NamedTuple):
    """What is different about a start: factors, degrees about x, y and z, and a push.

    Attributes:
        friction, stiffness: over those of the scene.
        turn: (3,) degrees.
        push: body weights.
        heading: rad, of the push.
        when: s, when the push begins.
    """

    friction: float
    stiffness: float
    turn: FloatArray
    push: float
    heading: float
    when: float

    @classmethod
    def of(cls, number: int, seconds: float, push: float) -> PerturbedStart:
        """The start of a number, in a run of so many seconds."""
        random = np.random.default_rng(number)
        friction, stiffness = random.uniform(1.0 - FACTOR, 1.0 + FACTOR, 2).tolist()
        turn = random.uniform(-TILT, TILT, 3)
        heading, when = random.uniform(0.0, (2.0 * math.pi, seconds - PUSH_SECONDS)).tolist()
        return cls(friction, stiffness, turn, push, heading, when)

    def plan(self, scene: str, settings: dict[str, float], levels: int) -> ScenePlan:
        """The scene so begun, its mesh refined ``levels`` times."""
        friction = scenes.make(scene, settings).settings["friction"] * self.friction
        plan = scenes.make(scene, {**settings, "friction": friction})
        character = plan.scene.character
        modulus = character.material.young_modulus * self.stiffness
        character = changed_character(character, "material.young_modulus", modulus)
        begun = refined_scene(replace(plan.scene, character=character), levels)
        mesh = begun.character.mesh
        pose = Rotation.from_euler("xyz", self.turn, degrees=True).apply(np.array(mesh.points))
        pose -= [0.0, 0.0, pose[:, 2].min()]
        size = self.push * character.material.density * mesh.volume * STANDARD_GRAVITY
        push = Push(
            region="head",
            force=(size * math.cos(self.heading), size * math.sin(self.heading), 0.0),
            start=self.when,
            duration=PUSH_SECONDS,
        )
        return replace(plan, scene=replace(begun, initial_pose=pose, pushes=(push,)))


class StartOutcome(NamedTuple):
    """What came of a start: every number that is asked, what fails, and CPU seconds a second."""

    values: list[str]
    failures: list[str]
    cost: float


def outcome(scene: str, plan: ScenePlan, stage: Path) -> StartOutcome:
    """Run a scene and measure its stage."""
    options = SimulationOptions(time_step=plan.time_step)
    simulation = Simulation(plan.scene, plan.controller, options=options, fps=60.0, name=scene)
    begun = time.process_time()
    try:
        with StageWriter(stage, plan.scene, fps=simulation.fps) as writer:
            for frame in simulation.run(plan.seconds):
                writer.write(frame)
    except NotFiniteError as error:
        return StartOutcome([], [str(error)], math.inf)
    cost = (time.process_time() - begun) / plan.seconds
    motion = RecordedMotion.read(stage, plan.scene.character)
    values, failures = [], []
    for criterion in CRITERIA[scene]:
        value = criterion.of(motion)
        values.append(criterion.text(value))
        if not criterion.holds(value):
            failures.append(f"{criterion.name} {criterion.text(value)}")
    return StartOutcome(values, failures, cost)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a row a start, and how many were survived."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.perturbed_starts")
    parser.add_argument("scene", choices=sorted(CRITERIA))
    parser.add_argument("--count", type=int, default=50, help="starts")
    parser.add_argument("--first", type=int, default=0, help="number of the first start")
    parser.add_argument("--push", type=float, default=PUSH, help="body weights")
    parser.add_argument("--levels", type=int, default=0, help="refinements of the mesh")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    given = parser.parse_args(arguments)
    settings = {name: float(value) for name, value in (each.split("=") for each in given.set)}
    seconds = scenes.recipe(given.scene).seconds
    survived = 0
    with TemporaryDirectory() as folder:
        for number in range(given.first, given.first + given.count):
            start = PerturbedStart.of(number, seconds, given.push)
            plan = start.plan(given.scene, settings, given.levels)
            came = outcome(given.scene, plan, Path(folder) / "motion.usdc")
            survived += not came.failures
            told = ", ".join(came.failures) or f"holds: {', '.join(came.values)}"
            print(
                f"{number:3d}  friction {start.friction:.2f}  stiffness {start.stiffness:.2f}  "
                f"CPU {came.cost:.2f} s a second  {told}",
                flush=True,
            )
    print(f"{survived} of {given.count} survived")


if __name__ == "__main__":
    main()
