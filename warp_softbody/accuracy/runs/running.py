"""One run of one point, in whatever process it is asked for; what comes back is small."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody import __version__
from warp_softbody.accuracy.cases.settings import Settings

Path3 = npt.NDArray[np.float32]

FPS = 30.0
REPEATS, ENOUGH = 3, 2.0
"""Runs of a point, while they have taken less CPU time than so many s; the least cost counts."""

UNTIMED_STEPS = 2
"""The first step of either of the two states that are swapped captures its graphs."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A point to be run.

    Attributes:
        scene: its name.
        given: settings of the scene beside `Settings.cells`.
        seconds: simulated, s.
        functionals: names of those to be measured.
        settings: the knobs.
        solver: "ours", or the name of a peer.
    """

    scene: str
    given: Mapping[str, float] = field(default_factory=dict)
    seconds: float
    functionals: tuple[str, ...]
    settings: Settings
    solver: str = "ours"

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {**asdict(self), "given": dict(self.given), "functionals": list(self.functionals)}

    @cached_property
    def key(self) -> str:
        """The same for the same scene, settings and version of the program."""
        scene = fingerprint(self.scene, tuple(sorted(self.given.items())), self.settings.cells)
        values = {**self.to_dict(), "fingerprint": scene, "version": __version__}
        text = json.dumps(values, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a run came to.

    Attributes:
        status: "complete", or the sentence that ended it.
        cost: CPU time of the process, ms per simulated second, set-up and first steps apart; the
            least of up to REPEATS runs.
        setup: CPU time before, s.
        memory: of the arrays that the run holds, MB.
        tets, nodes: sizes.
        iterations, passes, qps: means a step.
        unconverged: share of the steps that did not settle.
        functionals: values by name.
        path: (f, k, 3) m, places of the scene's material points by frame.
    """

    status: str
    cost: float
    setup: float
    memory: float
    tets: int
    nodes: int
    iterations: float
    passes: float
    qps: float
    unconverged: float
    functionals: Mapping[str, float]
    path: Path3

    @property
    def complete(self) -> bool:
        """Whether it came to its end."""
        return self.status == "complete"


@lru_cache
def fingerprint(scene: str, given: tuple[tuple[str, float], ...], cells: int | None) -> str:
    """Of the bodies, of what acts on them and of the controller's numbers, before refinement."""
    plan = Settings(time_step=1.0, cells=cells).plan(scene, dict(given))
    found = hashlib.sha256(repr((plan.settings, plan.scene.pushes, plan.scene.gravity)).encode())
    if plan.controller is not None:
        numbers = [repr(value) for value in vars(plan.controller).values()]
        # objects without a text of their own are told by an address, which changes
        found.update("".join(text for text in numbers if " at 0x" not in text).encode())
    for body in plan.scene.characters:
        found.update(body.mesh.points.tobytes() + body.mesh.tets.tobytes())
        found.update(repr((body.material, body.directional_friction)).encode())
        for group in body.muscles:
            found.update(repr((group.name, group.strength, group.kernel_width)).encode())
        for fiber in body.fibers:
            found.update(repr((fiber.name, fiber.kind)).encode() + fiber.vertices.tobytes())
    return found.hexdigest()


def run_job(job: Job) -> Outcome:
    """Run a point here; a combination that the engine refuses is an outcome too."""
    from warp_softbody.accuracy.runs.inner_knobs import inner_knobs
    from warp_softbody.errors import InputError
    from warp_softbody.run.warp_session import warp_engine

    if job.solver != "ours":
        from warp_softbody.accuracy.runs.peer_runs import run_peer

        return run_peer(job)
    try:
        with warp_engine("cpu", on_compile=lambda: None), inner_knobs(job.settings):
            return _repeated(job)
    except InputError as error:
        return refused(str(error))


def refused(sentence: str) -> Outcome:
    """Of a run that never began."""
    counts = dict.fromkeys(("cost", "setup", "memory", "iterations", "passes", "qps"), 0.0)
    path = np.zeros((0, 0, 3), dtype=np.float32)
    return Outcome(
        status=sentence, tets=0, nodes=0, unconverged=0.0, functionals={}, path=path, **counts
    )


def _repeated(job: Job) -> Outcome:
    """The cheapest of some runs, which differ in nothing else: other work only adds to a cost."""
    best = _run(job)
    spent = best.cost
    for _ in range(REPEATS - 1):
        if spent * job.seconds > 1e3 * ENOUGH:
            break
        again = _run(job)
        spent += again.cost
        best = min(best, again, key=lambda outcome: outcome.cost)
    return best


def _run(job: Job) -> Outcome:
    from warp_softbody.accuracy.runs.footprint import array_bytes
    from warp_softbody.accuracy.runs.recording import Recording
    from warp_softbody.errors import InputError, NotFiniteError
    from warp_softbody.run.simulation import Simulation, whole_steps

    settings = job.settings
    begun = time.process_time()
    plan = settings.plan(job.scene, job.given)
    simulation = Simulation(
        plan.scene,
        plan.controller,
        options=settings.options(),
        fps=FPS,
        method="static" if settings.method == "static" else "qpcc",
        name=job.scene,
    )
    recording = Recording(job, plan.scene, simulation.model.masses)
    steps, _ = whole_steps(settings.time_step, FPS)
    spent, timed = 0.0, 0
    setup = time.process_time() - begun
    status = "complete"
    recording.add(0.0, simulation.view().positions)
    try:
        for number in range(1, steps * round(job.seconds * FPS) + 1):
            begun = time.process_time()
            simulation.step()
            taken = time.process_time() - begun
            if number <= UNTIMED_STEPS:
                setup += taken
            else:
                spent, timed = spent + taken, timed + 1
            if number % steps == 0:
                recording.add(simulation.time, simulation.view().positions)
    except (NotFiniteError, InputError) as error:
        # a plan refuses numbers that are not finite before the next step does
        status = str(error)
    summary = simulation.summary()
    count = max(1, round(summary.simulated_seconds / summary.time_step))
    return Outcome(
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
