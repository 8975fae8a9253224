"""Bodies in free flight over the whole range of stiffness, speed, place and time step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, get_args

import numpy as np

from tests.support.bodies import Rig, box, rig
from warp_softbody import Material
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import Precision

GRAVITY = 9.81
PRECISIONS: tuple[Precision, ...] = tuple(p for p in get_args(Precision) if p != "auto")

MOST: dict[Precision, float] = {"float32": 1e-5, "float64": 1e-9}
"""Momentum that may get lost in a second, of what there was."""


@dataclass(frozen=True)
class Flight:
    """A cube of 0.1 m that flies, kept apart from its numbers so that pytest can name it."""

    young_modulus: float
    poisson_ratio: float
    damping: float
    cells: int
    time_step: float
    place: float
    speed: float
    gravity: bool

    def __str__(self) -> str:
        """Short, for the name of a test."""
        return (
            f"E {self.young_modulus:.0e} nu {self.poisson_ratio} lambda {self.damping} "
            f"{6 * self.cells**3} tets dt {self.time_step:.0e} at {self.place:g} m "
            f"{self.speed:.3g} m/s{' falls' if self.gravity else ''}"
        )

    def rig(self, precision: Precision, **options: Any) -> Rig:
        """The cube before its first step."""
        material = Material(
            young_modulus=self.young_modulus,
            poisson_ratio=self.poisson_ratio,
            stiffness_damping=self.damping,
        )
        body = rig(
            box((self.cells,) * 3, (0.1, 0.1, 0.1), (self.place, 0.0, 0.0)),
            material=material,
            gravity=(0.0, 0.0, -GRAVITY if self.gravity else 0.0),
            precision=precision,
            time_step=self.time_step,
            **options,
        )
        body.place(velocities=(self.speed, 0.0, 0.0))
        return body


def flights(count: int, seed: int) -> list[Flight]:
    """Random flights, the same for a seed."""
    rng = np.random.default_rng(seed)
    return [
        Flight(
            young_modulus=10.0 ** rng.uniform(3.0, 10.0),
            poisson_ratio=float(rng.choice([0.0, 0.3, 0.45, 0.49])),
            damping=float(rng.choice([0.0, 0.01, 0.05])),
            cells=int(rng.choice([1, 2, 3, 4, 6])),
            time_step=10.0 ** rng.uniform(-4.0, -1.0),
            place=float(rng.choice([0.0, 1.0, 30.0, 1000.0])),
            speed=10.0 ** rng.uniform(-1.0, 2.0),
            gravity=bool(rng.random() < 0.5),
        )
        for _ in range(count)
    ]


def mean_velocity(body: Rig) -> FloatArray:
    """Momentum over mass, (3,) m/s."""
    return np.asarray(body.momentum / body.masses.sum())
