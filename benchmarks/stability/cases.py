"""What a stability case is: what is run, for how long, and what is asked of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from benchmarks.stability.bodies import bending_frequency
from benchmarks.stability.movers import CaseSetup
from benchmarks.stability.runs import Run
from benchmarks.stability.starts import Begin
from warp_softbody import Character

REDUCTION = 1e-3
"""Part of itself that the slowest motion is left with after half a run, in linear theory."""

FEWEST_STEPS = 40
NEAR = 0.01
"""How near an end has to come to the rest volume, and to the rest shape in units of its length."""


class StabilityGoal(Enum):
    """What a case asks for.

    RECOVER: the rest shape, and with it every tet's volume.
    VOLUME: the rest volume, no tet inside out; an undamped body still swings.
    TURN: the same, but for what the centrifugal forces add.
    STAY: nothing moves.
    """

    RECOVER = "recovers"
    VOLUME = "recovers its volume"
    TURN = "keeps its volume"
    STAY = "stays"


@dataclass(frozen=True, kw_only=True)
class StabilityCase:
    """One row of the table.

    Attributes:
        name: unique, also the name of its test.
        extreme: what is extreme, and of which body.
        goal: what is asked for.
        setting: what is run.
        forced: muscles do work, so that the energy may grow.
        inside_out: tets are inverted at the start. A rotation may then turn by any angle in a step,
            and the energy may rise from one step to the next, but never above that of the start.
        long: takes long, and is tested by ``make test-long``.
    """

    name: str
    extreme: str
    goal: StabilityGoal
    setting: CaseSetup
    forced: bool = False
    inside_out: bool = False
    long: bool = False

    def failures(self, run: Run) -> dict[str, str]:
        """What a run fails in: the check's name, and the number that fails it."""
        if run.stopped is not None:
            return {"finite": f"stops at step {run.stopped}"}
        if run.overlooked is not None:
            return {"finite": f"not finite and not noticed at step {run.overlooked}"}
        failed = _far_from_rest(self.goal, run)
        growth = max(0.0, run.peak - run.start) if self.inside_out else run.growth
        if growth > 0.0 and not self.forced:
            failed["energy"] = f"energy rises by {100.0 * growth / run.start:.2g} % of the start's"
        if run.spin > run.spin_allowance and self.free:
            failed["spin"] = f"spin changes by {run.spin:.2g} kg m^2/s"
        return failed

    @property
    def free(self) -> bool:
        """Whether nothing outside the body can turn it."""
        return self.setting.ground is None and not len(self.setting.make().fixed)


def _far_from_rest(goal: StabilityGoal, run: Run) -> dict[str, str]:
    failed = {}
    if goal is StabilityGoal.STAY:
        if run.drift > run.drift_allowance:
            failed["drift"] = f"drifts {run.drift:.1e} m"
        return failed
    expected = 1.0 + (run.centrifugal if goal is StabilityGoal.TURN else 0.0)
    if not abs(run.volume - expected) < NEAR:
        failed["volume"] = f"volume {run.volume:.4g}"
    if run.inverted:
        failed["tets"] = f"{run.inverted} tets inverted"
    if goal is StabilityGoal.RECOVER:
        if not run.inverted and not run.smallest > 1.0 - NEAR:
            failed["tets"] = f"a tet of volume {run.smallest:.3g}"
        if not run.shape < NEAR:
            failed["shape"] = f"shape off by {run.shape:.3g}"
    return failed


def spectral_radius(frequency: float, time_step: float, damping: float) -> float:
    """Largest factor by which a step multiplies a vibration.

    That of ``(1 + dt lambda w^2 + dt^2 w^2) v+ = v - dt w^2 x``, ``x+ = x + dt v+``, at the given
    frequency w and, for stiffer vibrations, in the limit of large w.
    """
    square = frequency**2
    factor = 1.0 + time_step * damping * square + time_step**2 * square
    speed = np.array([-time_step * square, 1.0]) / factor
    step = np.array([np.array([1.0, 0.0]) + time_step * speed, speed])
    slow = float(np.abs(np.linalg.eigvals(step)).max())
    return max(slow, damping / (damping + time_step))


def settling_steps(frequency: float, time_step: float, damping: float) -> int:
    """Steps of a run: twice those that leave the slowest motion with ``REDUCTION`` of itself.

    The second half is for the time in which the body is far from its rest shape.
    """
    radius = spectral_radius(frequency, time_step, damping)
    return max(FEWEST_STEPS, 2 * math.ceil(math.log(REDUCTION) / math.log(radius)))


def slowest_frequency(character: Character) -> float:
    """Of a damped bar's bending, or of an undamped one's stretching, which its volume follows."""
    material, mesh = character.material, character.mesh
    if material.stiffness_damping > 0.0:
        return bending_frequency(mesh, material)
    speed = math.sqrt(material.young_modulus / material.density)
    length = float(np.ptp(mesh.points, axis=0).max())
    return 0.5 * math.pi * speed / length


def release(
    name: str,
    extreme: str,
    make: Callable[[], Character],
    *begins: Begin,
    time_step: float = 0.01,
    patience: int = 1,
    inside_out: bool = False,
    long: bool = False,
) -> StabilityCase:
    """A body without gravity is let go from each of some starts and is to recover.

    ``patience`` multiplies the time it has for that.
    """
    character = make()
    damping = character.material.stiffness_damping
    steps = settling_steps(slowest_frequency(character), time_step, damping)
    return StabilityCase(
        name=name,
        extreme=extreme,
        goal=StabilityGoal.RECOVER if damping > 0.0 else StabilityGoal.VOLUME,
        setting=CaseSetup(make=make, starts=begins, time_step=time_step, steps=patience * steps),
        inside_out=inside_out,
        long=long,
    )
