"""Warm-started sequences: recorded from a controlled run, and generated with changing contacts."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from warp_softbody import scenes
from warp_softbody.controllers import (
    COLD_OPTIONS,
    WARM_OPTIONS,
    ContactQPCC,
    SolverOptions,
    solve_qpcc,
    solve_static,
)
from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.controllers.perturbation_schedule import PerturbationSchedule
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.run.simulation import Simulation
from warp_softbody.run.step_record import StepRecord

STICK = 1

PLAIN = SolverOptions(max_qps=40, kicks=0)
KICKED = WARM_OPTIONS
THOROUGH = SolverOptions(max_qps=40, kicks=12)
REFERENCE = replace(COLD_OPTIONS, max_qps=1500, kicks=300, starts=12)


@dataclass(frozen=True)
class Step:
    """One step's problem, and a number for every contact that lasts as long as the contact."""

    problem: ContactQPCC
    names: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class SequenceOutcome:
    """One setting on one sequence.

    Attributes:
        qps: mean per step.
        gap: mean share of the gain of the reference over the static baseline that is missed.
        total: the same share of the sums over the sequence.
        milliseconds: median CPU time of a solve.
        residual: largest complementarity.
    """

    qps: float
    gap: float
    total: float
    milliseconds: float
    residual: float


def problems_of(
    name: str, seconds: float, settings: Mapping[str, float] | None = None
) -> list[ContactQPCC]:
    """The problems of the steps of a shipped motion."""
    plan = scenes.make(name, settings)
    options = SimulationOptions(time_step=plan.time_step)
    simulation = Simulation(plan.scene, plan.controller, options=options)
    found: list[ContactQPCC] = []

    def keep(step: StepRecord) -> None:
        if step.decision is not None:
            found.append(step.decision.problem)

    simulation.observe(keep)
    for _ in simulation.run(seconds):
        pass
    return found


def recorded(seconds: float = 3.0, push: float = 0.5) -> list[Step]:
    """A run's problems; patches keep their order, so their places name them."""
    problems = problems_of("balance-i", seconds, {"push": push})
    return [Step(problem, tuple(range(problem.contact_count))) for problem in problems]


def generated(contacts: int, steps: int, seed: int = 0) -> list[Step]:
    """A soft body whose aims sway while contacts come and go; about ``contacts`` touch at a time.

    The mobility is that of a random body with 30 more unknowns; goals and free velocity follow
    sines, so that neighbouring steps are alike; each contact touches for two thirds of its period.
    """
    rng = np.random.default_rng(seed)
    every, nu = -(-3 * contacts // 2), 3 * contacts
    k, size = 3 * every, 3 * every + 30
    factor = rng.normal(size=(size, size))
    mobility = factor @ factor.T / size + 0.05 * np.eye(size)
    muscles = 0.6 * rng.normal(size=(size, nu))
    rows = rng.normal(size=(8, size))
    phase, rate = rng.uniform(0, 2 * np.pi, size=every), rng.uniform(0.02, 0.06, size=every)
    sway = rng.normal(size=(2, size + 8))
    out = []
    for step in range(steps):
        angle = 0.1 * step
        moved = np.cos(angle) * sway[0] + np.sin(angle) * sway[1]
        velocity = 0.5 * moved[:size]
        velocity[0:k:3] -= 0.4
        names = np.flatnonzero(np.sin(phase + rate * step) > -0.5)
        own = (3 * names[:, None] + np.arange(3)).reshape(-1)
        slopes = np.hstack([rows @ mobility @ muscles, rows @ mobility[:, own]])
        error = rows @ velocity + 0.5 * moved[size:]
        effort = np.diag(np.r_[np.full(nu, 1e-2), np.zeros(len(own))])
        problem = ContactQPCC(
            hessian=slopes.T @ slopes + effort,
            gradient=slopes.T @ error,
            constant=0.5 * float(error @ error),
            lower=np.full(nu, -0.5),
            upper=np.full(nu, 0.5),
            velocity_offset=velocity[own],
            velocity_from_controls=(mobility @ muscles)[own],
            velocity_from_forces=mobility[np.ix_(own, own)],
            friction=np.full(len(names), 0.7),
        )
        out.append(Step(problem, tuple(int(name) for name in names)))
    return out


def references(sequence: list[Step]) -> list[float]:
    """The best value of a long cold search for every step."""
    return [solve_qpcc(step.problem, options=REFERENCE).objective for step in sequence]


def follow(
    sequence: list[Step], best: list[float], options: SolverOptions, *, ruled: bool = False
) -> SequenceOutcome:
    """Solve a sequence, each step from the last one's modes; new contacts begin by sticking.

    ``best`` is lowered where this run finds something better. With ``ruled`` kicks are left out as
    a run leaves them out.
    """
    modes: dict[int, int] = {}
    rule = PerturbationSchedule(ControlOptions(), options)
    qps, times, values, residual = [], [], [], 0.0
    for i, step in enumerate(sequence):
        start = tuple(modes.get(name, STICK) for name in step.names)
        began = time.process_time()
        chosen = rule.options() if ruled else options
        result = solve_qpcc(step.problem, start=start, options=chosen)
        times.append(time.process_time() - began)
        rule.note(start, result, usable=True)
        qps.append(result.qp_count)
        values.append(result.objective)
        residual = max(residual, result.complementarity)
        best[i] = min(best[i], result.objective)
        modes = dict(zip(step.names, result.modes, strict=True))
    static = np.array([solve_static(step.problem).objective for step in sequence])
    ours, least = np.array(values), np.array(best)
    gain = static - least
    # Where the static point is the reference to rounding there is no gain to miss a share of.
    counted = gain > 1e-4 * (1e-9 + np.abs(least))
    share = (ours - least)[counted] / gain[counted]
    return SequenceOutcome(
        qps=float(np.mean(qps)),
        gap=float(np.mean(share)) if counted.any() else 0.0,
        total=float((ours - least).sum() / max(gain.sum(), 1e-12)),
        milliseconds=1e3 * float(np.median(times)),
        residual=residual,
    )
