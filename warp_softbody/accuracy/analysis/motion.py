"""Motions and how far apart they are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from warp_softbody.accuracy.cases.functionals import FUNCTIONALS
from warp_softbody.accuracy.runs.outcome import RunOutcome
from warp_softbody.arrays import FloatArray


@dataclass(frozen=True, kw_only=True)
class MeasuredMotion:
    """A run's motion, or a limit of several.

    Attributes:
        path: (f, k, 3) m, places of material points by frame.
        functionals: values by name.
    """

    path: FloatArray
    functionals: Mapping[str, float]


def motion_of(outcome: RunOutcome | None) -> MeasuredMotion | None:
    """That of a complete run."""
    if outcome is None or not outcome.complete:
        return None
    return MeasuredMotion(path=outcome.path.astype(np.float64), functionals=outcome.functionals)


def extrapolated(fine: MeasuredMotion, coarse: MeasuredMotion) -> MeasuredMotion:
    """The limit of a first-order method from steps of dt and 2 dt."""
    return MeasuredMotion(
        path=2.0 * fine.path - coarse.path,
        functionals={
            name: 2.0 * value - coarse.functionals[name] for name, value in fine.functionals.items()
        },
    )


def corrected(
    motion: MeasuredMotion, fine: MeasuredMotion, coarse: MeasuredMotion
) -> MeasuredMotion:
    """A motion and, on top, the difference between two others."""
    return MeasuredMotion(
        path=motion.path + fine.path - coarse.path,
        functionals={
            name: value + fine.functionals[name] - coarse.functionals[name]
            for name, value in motion.functionals.items()
        },
    )


def responding(
    motion: MeasuredMotion, there: MeasuredMotion, here: MeasuredMotion
) -> MeasuredMotion:
    """A motion as it would be elsewhere if it changed as another one does from here to there.

    Numbers that are measured against themselves change by the same share, others by as much. Only
    numbers are taken there: the path is that of ``there``, which may be longer.
    """
    moved = {
        name: value + there.functionals[name] - here.functionals[name]
        for name, value in motion.functionals.items()
    }
    shares = {
        name: value * there.functionals[name] / here.functionals[name]
        for name, value in motion.functionals.items()
        if FUNCTIONALS[name].scale is None and here.functionals[name]
    }
    return replace(there, functionals={**moved, **shares})


@dataclass(frozen=True, kw_only=True)
class Ruler:
    """What distances between motions are measured with.

    Attributes:
        size: of the body, m.
        by_functionals: whether the largest difference of a functional counts, not the nodes'.
    """

    size: float
    by_functionals: bool

    def distance(self, motion: MeasuredMotion, reference: MeasuredMotion) -> float:
        """Relative: root mean square over points and frames, or of the worst functional."""
        if self.by_functionals:
            return max(self.differences(motion, reference).values())
        apart = motion.path - reference.path
        return float(np.sqrt((apart**2).sum(axis=2).mean())) / self.size

    def differences(self, motion: MeasuredMotion, reference: MeasuredMotion) -> dict[str, float]:
        """Of each functional, relative to its scale; infinite where that is 0, as of a height.

        Those with a limit are no outcomes, and are left out.
        """
        found = {}
        for name, value in reference.functionals.items():
            if FUNCTIONALS[name].limit is not None:
                continue
            apart = abs(motion.functionals[name] - value)
            scale = FUNCTIONALS[name].scale or abs(value)
            found[name] = apart / scale if scale else (np.inf if apart else 0.0)
        return found
