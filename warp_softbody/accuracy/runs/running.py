"""One run of one point, in whatever process it is asked for; what comes back is small."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from warp_softbody.accuracy.runs.job import FPS, UNTIMED_STEPS, Job
from warp_softbody.accuracy.runs.outcome import RunOutcome, refused

if TYPE_CHECKING:
    from warp_softbody.engine.model import Model

REPEATS, ENOUGH = 3, 1.0
"""Runs of a point, while they have taken less CPU time than so many s; the least cost counts."""


def run_job(job: Job) -> RunOutcome:
    """Run a point here; a combination that the engine refuses is an outcome too."""
    from warp_softbody.errors import InputError
    from warp_softbody.run.warp_session import warp_engine

    if job.solver != "ours":
        from warp_softbody.accuracy.runs.peer_runs import run_peer

        return run_peer(job)
    try:
        with warp_engine("cpu", on_compile=lambda: None):
            return _repeated(job)
    except InputError as error:
        return refused(str(error))


def _repeated(job: Job) -> RunOutcome:
    """The cheapest of some runs, which differ in nothing else: other work only adds to a cost.

    They share what is constant in their models; the set-up is that of the first.
    """
    first, model = _run(job)
    best, spent = first, first.cost
    for _ in range(REPEATS - 1):
        if spent * job.seconds > 1e3 * ENOUGH:
            break
        again, model = _run(job, model)
        spent += again.cost
        best = min(best, again, key=lambda outcome: outcome.cost)
    return replace(best, setup=first.setup)


def _run(job: Job, like: Model | None = None) -> tuple[RunOutcome, Model]:
    """A run and its model, which shares what it can with that of another."""
    from warp_softbody.accuracy.runs.footprint import array_bytes
    from warp_softbody.accuracy.runs.recording import Recording
    from warp_softbody.accuracy.runs.soundness_monitor import FPS as SEEN
    from warp_softbody.errors import InputError, NotFiniteError
    from warp_softbody.run.run_settings import whole_steps
    from warp_softbody.run.simulation import Simulation

    settings = job.settings
    begun = time.process_time()
    plan = settings.plan(job.scene, job.given)
    simulation = Simulation(
        plan.scene,
        plan.controller,
        options=settings.options(),
        control_options=settings.control_options(),
        fps=FPS,
        name=job.scene,
        like=like,
    )
    recording = Recording(job, plan.scene, simulation.model.masses)
    steps, _ = whole_steps(settings.time_step, FPS)
    spent, timed, every = 0.0, 0, max(1, round(1.0 / (SEEN * settings.time_step)))
    setup = time.process_time() - begun
    status = "complete"
    recording.add(0.0, simulation.view().positions)
    recording.see(simulation.view())
    try:
        for number in range(1, steps * round(job.seconds * FPS) + 1):
            begun = time.process_time()
            simulation.step()
            taken = time.process_time() - begun
            if number <= UNTIMED_STEPS:
                setup += taken
            else:
                spent, timed = spent + taken, timed + 1
            if number % every == 0:
                recording.see(simulation.view())
            if number % steps == 0:
                recording.add(simulation.time, simulation.view().positions)
    except (NotFiniteError, InputError) as error:
        # a plan refuses numbers that are not finite before the next step does
        status = str(error)
    summary = simulation.summary()
    count = max(1, round(summary.simulated_seconds / summary.time_step))
    outcome = RunOutcome(
        status=status,
        cost=1e3 * spent / max(1, timed) / summary.time_step,
        setup=setup,
        memory=1e-6 * array_bytes(simulation),
        tets=summary.tets,
        nodes=summary.nodes,
        iterations=summary.cg_iterations.mean,
        passes=summary.contact_passes.mean,
        qps=summary.qps_per_step.mean,
        unconverged=summary.unconverged_steps / count,
        functionals=recording.functionals() if status == "complete" else {},
        path=recording.path(),
    )
    return outcome, simulation.model
