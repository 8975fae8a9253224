"""What is not spent where a scene has no need of it: ``python -m benchmarks.economy``.

Every comparison runs both sides in turn, a few steps at a time, so that a change of the machine's
speed hits both; ratios are of CPU times of the process (sums over the steps after the first two).

  at rest         a step while all bodies sleep, over one while they move
  no muscles      a letter with muscles that nothing drives over the same without
  no contact      a cube in flight without a ground over one far above it
  linear solve    stopped with the time error over stopped at its tolerance
  preconditioner  kept while it serves over made anew in every step
  QPCC            share of a controlled run's steps that keep the modes of the step before, and QPs
                  in these and in all
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from benchmarks.beam.arguments import count
from warp_softbody import scenes
from warp_softbody.controllers import QPCCResult
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.step_record import StepRecord
from warp_softbody.scenes.balance_i import balancing_letter
from warp_softbody.world.scene import Scene

Make = Callable[[], Simulation]
IN_TURN = 5
UNTIMED = 2
MANY = 10**9
"""Iterations that no factor is worth."""

IN_FLIGHT = 100
"""Steps before a cube dropped from 5 m lands."""
PASSIVE = ("cantilever", "twisted-bar", "drop-block", "bounce-ball", "slope", "stack")


def plain(name: str, **options: Any) -> Simulation:
    """A passive scene as shipped, but for some options."""
    plan = scenes.make(name, {})
    return of_scene(plan.scene, **{"time_step": plan.time_step, **options})


def of_scene(scene: Scene, **options: Any) -> Simulation:
    """A scene with some options."""
    return Simulation(scene, options=SimulationOptions(**options))


def restless(name: str) -> Simulation:
    """A passive scene whose preconditioner is stale after every step."""
    simulation = plain(name)
    kept = simulation.stepper.contact.preconditioner
    simulation.observe(lambda step: kept.used(MANY, fresh=0))
    return simulation


def ratio(first: Make, second: Make, steps: int) -> float:
    """CPU time of the first over that of the second."""
    sides = (first(), second())
    spent = [0.0, 0.0]
    for simulation in sides:
        for _ in range(UNTIMED):
            simulation.step()
    for _ in range(0, steps, IN_TURN):
        for k, simulation in enumerate(sides):
            begun = time.process_time()
            for _ in range(IN_TURN):
                simulation.step()
            spent[k] += time.process_time() - begun
    return spent[0] / spent[1]


def at_rest(name: str, steps: int, seconds: float) -> float:
    """A sleeping step over one of the first ``steps``, in one run."""
    simulation = plain(name)
    for _ in range(UNTIMED):
        simulation.step()
    moving = _cpu(simulation, steps)
    while simulation.time < seconds and not simulation.asleep:
        simulation.step()
    return _cpu(simulation, 10 * steps) / (10 * moving)


def _cpu(simulation: Simulation, steps: int) -> float:
    begun = time.process_time()
    for _ in range(steps):
        simulation.step()
    return time.process_time() - begun


def qps(name: str, seconds: float) -> tuple[float, float, float]:
    """Share of a controlled run's steps that keep their modes; QPs in these, and in all."""
    plan = scenes.make(name, {})
    simulation = Simulation(plan.scene, plan.controller, time_step=plan.time_step)
    taken: list[QPCCResult] = []

    def keep(step: StepRecord) -> None:
        # steps in which the controller wants nothing take no QP
        if step.decision is not None:
            taken.append(step.decision.result)

    simulation.observe(keep)
    while simulation.time < seconds:
        simulation.step()
    pairs = itertools.pairwise(taken)
    kept = [after.qp_count for before, after in pairs if after.modes == before.modes]
    mean = sum(result.qp_count for result in taken) / len(taken)
    return len(kept) / len(taken), sum(kept) / max(1, len(kept)), mean


def report(steps: int, seconds: float, controlled: Sequence[str]) -> None:
    """Print every comparison."""
    for name in ("drop-block", "stack"):
        share = at_rest(name, steps, 10.0 * seconds)
        print(f"at rest         {name:12} {100.0 * share:.2f} % of a moving step", flush=True)
    letter = balancing_letter()
    bare = Scene(character=replace(letter, muscles=()))
    muscular = Scene(character=letter)
    found = ratio(lambda: of_scene(muscular), lambda: of_scene(bare), steps)
    print(f"no muscles      letter-i     {found:.2f} with 48 slack segments", flush=True)
    floor = scenes.make("drop-block", {"height": 5.0}).scene
    flight = replace(floor, ground=None)
    found = ratio(lambda: of_scene(flight), lambda: of_scene(floor), min(steps, IN_FLIGHT))
    print(f"no contact      drop-block   {found:.2f} of the flight above a floor", flush=True)
    for name in PASSIVE:
        found = ratio(
            lambda: plain(name),  # noqa: B023
            lambda: plain(name, tolerance=SimulationOptions().solver_tolerance),  # noqa: B023
            steps,
        )
        print(f"linear solve    {name:12} {found:.2f} of a solve to its tolerance", flush=True)
    for name in ("cantilever", "slope", "bounce-ball"):
        found = ratio(lambda: plain(name), lambda: restless(name), steps)  # noqa: B023
        print(f"preconditioner  {name:12} {found:.2f} of one made anew each step", flush=True)
    for name in controlled:
        kept, few, mean = qps(name, seconds)
        text = f"{100.0 * kept:.0f} % of steps keep their modes"
        print(f"QPCC            {name:12} {text}: {few:.1f} QPs; {mean:.1f} in all", flush=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the comparisons asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.economy", description=__doc__)
    parser.add_argument("--steps", type=count, default=100, help="of each side of a comparison")
    parser.add_argument("--seconds", type=float, default=2.0, help="of each controlled run")
    parser.add_argument(
        "--controlled", nargs="*", default=["balance-i", "roll-o", "walk-x"], metavar="SCENE"
    )
    args = parser.parse_args(arguments)
    report(args.steps, args.seconds, args.controlled)


if __name__ == "__main__":
    main()
