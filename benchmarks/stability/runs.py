"""One stability run: a body is stepped from where it starts, and measured."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from benchmarks.stability.measures import StateSample
from benchmarks.stability.movers import CaseSetup, Mover, StepNote
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.state import SLACK

SAMPLES = 100
"""Times at which a run is measured, besides its start and end."""

FULL = 0.5
"""l_d / l_0 of a muscle pulled as far as it goes."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run in numbers.

    Attributes:
        stopped: step at which the stepper said that numbers are not finite, or None.
        overlooked: step at whose end numbers were not finite though it said they were, or None.
        volume: of the body at the end over that at rest.
        smallest: the same of the tet where it is least.
        inverted: tets inside out at the end.
        shape: largest distance of a node from the rest shape, over the body's length.
        start: energy at the start, J.
        peak: largest energy of the run, J.
        growth: largest rise of the energy from one sample to the next beyond what the solver's
            residual and rounding explain, J; 0 where there is none.
        spin: change of the angular momentum about the centre of mass from start to end, kg m^2/s.
        spin_allowance: what residuals and rounding can change it by.
        centrifugal: relative growth of the volume that the kinetic energy at the end explains.
        drift: largest distance, m, of a node from where it was after a hundredth of the run.
        drift_allowance: what residuals and roundings, independent of each other, add up to, m.
        iterations: of conjugate gradients, mean of a step.
        steps: made.
        unconverged: steps whose linear solve or contact modes did not converge.
    """

    stopped: int | None = None
    overlooked: int | None = None
    volume: float = float("nan")
    smallest: float = float("nan")
    inverted: int = 0
    shape: float = float("nan")
    start: float = 0.0
    peak: float = 0.0
    growth: float = 0.0
    spin: float = 0.0
    spin_allowance: float = 0.0
    centrifugal: float = 0.0
    drift: float = 0.0
    drift_allowance: float = 0.0
    iterations: float = 0.0
    steps: int = 0
    unconverged: int = 0


@dataclass
class _Log:
    """What is gathered while a run goes on."""

    samples: list[StateSample] = field(default_factory=list)
    settled: FloatArray = field(default_factory=lambda: np.zeros(3))
    steps: int = 0
    iterations: int = 0
    unconverged: int = 0

    def count(self, note: StepNote) -> None:
        """Add a step."""
        self.steps += 1
        self.iterations += note.iterations
        self.unconverged += not note.converged


def run(setting: CaseSetup, body: Mover) -> Run:
    """Step a body through a setting from where it starts."""
    log = _Log()
    log.samples.append(body.sample())
    stride = -(-setting.steps // SAMPLES)
    for step in range(setting.steps):
        if setting.pulled and step in (0, setting.pulled):
            body.pull(FULL if step == 0 else SLACK)
        note = body.step()
        log.count(note)
        if not note.finite:
            return Run(stopped=step, steps=log.steps, unconverged=log.unconverged)
        if step == setting.steps // 100:
            log.settled = body.positions
        if (step + 1) % stride == 0 or step + 1 == setting.steps:
            if not (np.isfinite(body.positions).all() and np.isfinite(body.velocities).all()):
                return Run(overlooked=step, steps=log.steps, unconverged=log.unconverged)
            log.samples.append(body.sample())
    return _summary(setting, body, log, stride)


def _summary(setting: CaseSetup, body: Mover, log: _Log, stride: int) -> Run:
    positions, probe, samples, steps = body.positions, body.probe, log.samples, log.steps
    material, volumes = body.character.material, probe.volumes(positions)
    # the virial of a turning body, integral of tr(stress) = 2 kinetic energy, in Hooke's law
    compliance = (1.0 - 2.0 * material.poisson_ratio) / material.young_modulus
    pairs = list(itertools.pairwise(samples))
    rises = [
        after.energy - before.energy - stride * max(before.energy_allowance, after.energy_allowance)
        for before, after in pairs
    ]
    spins = [stride * max(before.spin_allowance, after.spin_allowance) for before, after in pairs]
    return Run(
        volume=probe.volume(positions),
        smallest=float(volumes.min()),
        inverted=int((volumes <= 0.0).sum()),
        shape=probe.shape_error(positions),
        start=samples[0].energy,
        peak=max(sample.energy for sample in samples),
        growth=max(0.0, *rises),
        spin=float(np.linalg.norm(samples[-1].spin - samples[0].spin)),
        spin_allowance=sum(spins),
        centrifugal=2.0 * samples[-1].kinetic * compliance / body.character.mesh.volume,
        drift=float(np.linalg.norm(positions - log.settled, axis=1).max()),
        drift_allowance=_drift_allowance(setting, body, steps),
        iterations=log.iterations / steps,
        steps=steps,
        unconverged=log.unconverged,
    )


def _drift_allowance(setting: CaseSetup, body: Mover, steps: int) -> float:
    """A step may be off by a rounding of the position and by the residual of the weight's impulse.

    Such errors, independent of each other, add up with the square root of their number.
    """
    accuracy = body.accuracy
    weight = float(np.linalg.norm(setting.gravity))
    residual = accuracy.time_step**2 * accuracy.tolerance * weight
    return float(np.sqrt(steps) * (accuracy.epsilon * np.abs(body.positions).max() + residual))
