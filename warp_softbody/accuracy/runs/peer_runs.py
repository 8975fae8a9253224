"""Other programs on the charts, whose packages come with the extra ``bench``.

They are run in the same kind of process and measured in the same way as ours.
"""

from __future__ import annotations

import importlib
import time
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.accuracy.runs.flex import FlexOnFloor
from warp_softbody.accuracy.runs.job import FPS, UNTIMED_STEPS, Job
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.accuracy.runs.peers import missing_peer
from warp_softbody.accuracy.runs.peers.beam import Cantilever
from warp_softbody.accuracy.runs.recording import Recording
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.errors import MissingExtraError
from warp_softbody.world.scene import Scene

MUJOCO, PARDISO = "MuJoCo flex", "Pardiso"
TOLERANCE = 1e-5
"""Of MuJoCo's solve, as of ours in single precision."""
ENOUGH_ITERATIONS = 10_000


def require_peers() -> None:
    """Say early that peers cannot be run.

    Raises:
        MissingExtraError: the package of one of the peers is not there.
    """
    if problem := missing_peer():
        raise MissingExtraError(problem)


def run_peer(job: Job) -> RunOutcome:
    """Run a point by another program."""
    settings = job.settings
    begun = time.process_time()
    scene = settings.plan(job.scene, job.given).scene
    body = scene.character
    solver = _solver(job, scene)
    recording = Recording(job, scene, _masses(scene))
    recording.add(0.0, body.mesh.points)
    setup = time.process_time() - begun
    spent, timed, unconverged = 0.0, 0, 0
    steps = round(1.0 / (FPS * settings.time_step))
    total = steps * round(job.seconds * FPS)
    for number in range(1, total + 1):
        begun = time.process_time()
        report = solver.step()
        taken = time.process_time() - begun
        unconverged += not report.converged
        if number > UNTIMED_STEPS:
            spent, timed = spent + taken, timed + 1
        if number % steps == 0:
            recording.add(number * settings.time_step, solver.positions())
    return RunOutcome(
        status="complete",
        cost=1e3 * spent / max(1, timed) / settings.time_step,
        setup=setup,
        memory=0.0,
        tets=len(body.mesh.tets),
        nodes=len(body.mesh.points),
        iterations=0.0,
        passes=0.0,
        qps=0.0,
        unconverged=unconverged / total,
        functionals=recording.functionals(),
        path=recording.path(),
    )


def _solver(job: Job, scene: Scene) -> Any:
    if scene.ground is not None:
        return FlexOnFloor(scene, job.settings.time_step)
    character = scene.character
    held, tip = _mask(scene, character.fixed), _mask(scene, character.region("tip"))
    body = Cantilever(mesh=character.mesh, fixed=held, tip=tip)
    if job.solver == PARDISO:
        module = importlib.import_module("warp_softbody.accuracy.runs.peers.pardiso_step")
        return module.PardisoBeam(body, job.settings.time_step)
    module = importlib.import_module("warp_softbody.accuracy.runs.peers.mujoco_flex")
    return module.MujocoBeam(body, job.settings.time_step, TOLERANCE, ENOUGH_ITERATIONS)


def _mask(scene: Scene, nodes: npt.NDArray[np.int32]) -> npt.NDArray[np.bool_]:
    return np.isin(np.arange(len(scene.character.mesh.points)), nodes)


def _masses(scene: Scene) -> npt.NDArray[np.float64]:
    mesh, density = scene.character.mesh, scene.character.material.density
    return lumped_masses(mesh.tets, mesh.volumes, len(mesh.points), density)
