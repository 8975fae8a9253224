"""Plans against the steps that they led to: ``python -m benchmarks.plans``.

    python -m benchmarks.plans                            # a table of four motions by phase
    python -m benchmarks.plans --scenes balance-i --plots out/plans

A plan foresees the next velocities by patches in place of nodes, one linear step and forces of the
muscles as they are now; the step has all of its nodes' contacts. Of every planned step:

  momentum  |impulse of the ground, planned less realised| over m g dt
  feet      largest |velocity of a patch, planned less realised| over sqrt(g L)
  cost      |cost planned less realised| over the larger one, activations included in both; a cost
            below 1e-3 (a missing force of 3 % of the weight) counts as that

Phases: a body that was in the air lately (0.5 sqrt(L/g)) lands; one whose centre of mass is
slower than 0.02 sqrt(g L) stands; else it does what its scene is for.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warp_softbody import scenes
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.plan_outcome import PlanOutcome, plan_outcome
from warp_softbody.run.plot_tables import PlotTable
from warp_softbody.run.plots import check_plots, write_plots
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.step_record import StepRecord

MOTIONS = {"balance-i": "tipping", "jump-i": "jumping", "roll-o": "rolling", "walk-x": "walking"}
"""Scenes, and what a moving body does there."""

LANDING = 0.5
"""sqrt(L/g) after a flight."""
STANDING = 0.02
"""sqrt(g L), of the centre of mass."""


@dataclass(frozen=True, kw_only=True)
class PlanMiss:
    """What one step has in place of its plan.

    Attributes:
        phase: "air", "landing", "standing" or the scene's own.
        outcome: beside the plan.
    """

    phase: str
    outcome: PlanOutcome


def misses(name: str, seconds: float | None = None) -> list[PlanMiss]:
    """Of every planned step of a scene as shipped."""
    plan = scenes.make(name)
    options = SimulationOptions(time_step=plan.time_step)
    simulation = Simulation(plan.scene, plan.controller, options=options)
    found: list[PlanMiss] = []
    flown = -math.inf

    def keep(step: StepRecord) -> None:
        nonlocal flown
        decision = step.decision
        if decision is None or not decision.converged:
            return
        view, units = decision.view, BodyUnits.of(decision.view)
        # before the first step nobody knows what touches
        if view.time > 0.0 and not view.touching.any():
            flown = view.time
        phase = MOTIONS.get(name, "moving")
        if flown == view.time:
            phase = "air"
        elif view.time - flown < LANDING * units.time:
            phase = "landing"
        elif np.linalg.norm(view.linear_momentum) < STANDING * view.mass * units.speed:
            phase = "standing"
        velocities = np.asarray(step.state.velocities.numpy(), dtype=float)
        pushes = np.asarray(step.control.external_forces.numpy(), dtype=float)
        found.append(PlanMiss(phase=phase, outcome=plan_outcome(decision, velocities, pushes)))

    simulation.observe(keep)
    for _ in simulation.run(seconds or plan.seconds):
        pass
    return found


def by_phase(found: Sequence[PlanMiss]) -> dict[str, list[PlanMiss]]:
    """The steps of each phase, in order of the first one."""
    phases: dict[str, list[PlanMiss]] = {}
    for one in found:
        phases.setdefault(one.phase, []).append(one)
    return phases


def table(found: Mapping[str, Sequence[PlanMiss]]) -> str:
    """Medians and ninth tenths by scene and phase, %, as Markdown."""
    lines = [
        "| scene | phase | steps | momentum | feet | cost |",
        "|---|---|---|---|---|---|",
    ]
    for scene, steps in found.items():
        for phase, own in by_phase(steps).items():
            cells = [
                f"{100 * np.median(values):.1f}, {100 * np.quantile(values, 0.9):.1f} %"
                for values in (
                    [one.outcome.momentum_miss for one in own],
                    [one.outcome.feet_miss for one in own],
                    [one.outcome.cost_miss for one in own],
                )
            ]
            lines.append(f"| `{scene}` | {phase} | {len(own)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def plots(name: str, found: Sequence[PlanMiss]) -> tuple[PlotTable, PlotTable]:
    """Costs of plans and steps over time, and what the steps miss of the plans."""
    steps = [one.outcome for one in found]
    time = np.array([step.time for step in steps])
    costs = {
        key: np.array([getattr(step, key) for step in steps]) for key in ("planned", "reached")
    }
    off = {
        key: np.array([getattr(step, f"{key}_miss") for step in steps])
        for key in ("momentum", "feet", "cost")
    }
    return (
        PlotTable(
            name=f"{name}-cost",
            title="Cost of the plan, and of the step that came of it",
            unit="1",
            time=time,
            columns=costs,
            logarithmic=True,
        ),
        PlotTable(
            name=f"{name}-miss",
            title="What a step misses of its plan",
            unit="1",
            time=time,
            columns=off,
            logarithmic=True,
        ),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table; write plots where they are asked for."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.plans",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", nargs="+", default=list(MOTIONS), metavar="SCENE")
    parser.add_argument("--seconds", type=float, help="length of a run; default the scene's")
    parser.add_argument("--plots", type=Path, help="folder for a CSV and a PNG of each scene")
    args = parser.parse_args(arguments)
    folder = None if args.plots is None else check_plots(args.plots)
    found = {name: misses(name, args.seconds) for name in args.scenes}
    print(table(found))
    for name, steps in found.items() if folder is not None else ():
        assert folder is not None
        write_plots(plots(name, steps), folder)


if __name__ == "__main__":
    main()
