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
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.control_solver import Decision
from warp_softbody.engine.options import SimulationOptions
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
SMALL = 1e-3
"""Costs below this count as it."""


@dataclass(frozen=True, kw_only=True)
class PlanMiss:
    """What one step has in place of its plan.

    Attributes:
        time: s.
        phase: "air", "landing", "standing" or the scene's own.
        momentum: |impulse of the ground, planned less realised| over m g dt.
        feet: largest |velocity of a patch, planned less realised| over sqrt(g L).
        planned, reached: the cost, of the goals and of the activations.
    """

    time: float
    phase: str
    momentum: float
    feet: float
    planned: float
    reached: float

    @property
    def cost(self) -> float:
        """|planned less reached| over the larger one."""
        larger = max(abs(self.planned), abs(self.reached), SMALL)
        return abs(self.planned - self.reached) / larger


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
        found.append(miss(decision, velocities, pushes, phase))

    simulation.observe(keep)
    for _ in simulation.run(seconds or plan.seconds):
        pass
    return found


def miss(decision: Decision, velocities: FloatArray, pushes: FloatArray, phase: str) -> PlanMiss:
    """Of a decision, the velocities (n, 3) m/s that it led to and outer forces (n, 3) N."""
    view, goals, result = decision.view, decision.goals, decision.result
    units, step = BodyUnits.of(view), view.time_step
    impulses = np.asarray(result.forces).reshape(-1, 3)
    count = sum(len(objective.rows) for objective in goals.objectives)
    planned_rows = planned_values(decision)
    planned = reached = 0.0
    begin = 0
    for objective in goals.objectives:
        end = begin + len(objective.rows)
        realised = objective.rows @ velocities.ravel()
        planned += float(objective.weight @ (planned_rows[begin:end] - objective.target) ** 2)
        reached += float(objective.weight @ (realised - objective.target) ** 2)
        begin = end
    ground, feet = np.zeros(3), 0.0
    for number, patch in enumerate(goals.patches if len(impulses) else ()):
        ground += impulses[number] @ patch.frame
        rows = planned_rows[count + 3 * number : count + 3 * number + 3]
        off = rows - patch.frame @ (patch.weights @ velocities)
        feet = max(feet, float(np.linalg.norm(off)))
    gained = view.masses @ (velocities - view.velocities) - step * pushes.sum(axis=0)
    gained -= step * view.mass * np.asarray(view.scene.gravity)
    activations = result.objective - planned
    return PlanMiss(
        time=view.time,
        phase=phase,
        momentum=float(np.linalg.norm(gained - ground)) / (view.weight * step),
        feet=feet / units.speed,
        planned=result.objective,
        reached=reached + activations,
    )


def planned_values(decision: Decision) -> FloatArray:
    """(q + 3K,) what a plan expects of the rows of all goals, and of its patches' velocities."""
    maps, impulses = decision.maps, np.asarray(decision.result.forces).ravel()
    chosen = decision.lengths_ahead - maps.lengths
    values = maps.free_velocity + maps.muscle_map @ chosen
    if len(impulses):
        values = values + maps.compliance[:, len(values) - len(impulses) :] @ impulses
    return np.asarray(values)


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
                    [one.momentum for one in own],
                    [one.feet for one in own],
                    [one.cost for one in own],
                )
            ]
            lines.append(f"| `{scene}` | {phase} | {len(own)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def plots(name: str, found: Sequence[PlanMiss]) -> tuple[PlotTable, PlotTable]:
    """Costs of plans and steps over time, and what the steps miss of the plans."""
    time = np.array([one.time for one in found])
    costs = {key: np.array([getattr(one, key) for one in found]) for key in ("planned", "reached")}
    off = {
        key: np.array([getattr(one, key) for one in found]) for key in ("momentum", "feet", "cost")
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
