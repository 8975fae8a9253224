"""How many random grounds a walking body crosses: `python -m benchmarks.uneven_grounds`.

Ground k has a slope between -15 and 15 degrees and hills of its own, 5 % of the body's length from
the deepest valley to the highest top. It is crossed where the centre of mass comes ten body lengths
ahead in time while the body never leans by more than 45 degrees against the ground's slope.
"""

from __future__ import annotations

import argparse
import time
from typing import NamedTuple

import numpy as np

from benchmarks.tables import as_text
from warp_softbody import scenes
from warp_softbody.accuracy.cases.body_motion import turned
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.simulation import Simulation

STEEPEST = 15.0  # degrees
MOST_LEANING = 45.0  # degrees
FRAMES = 5.0  # a second


class Crossing(NamedTuple):
    """What came of a ground.

    Attributes:
        slope: degrees.
        ahead: body lengths in the end.
        aside: body lengths, at most.
        leaning: degrees about y against the slope, at most.
        seconds: simulated.
    """

    slope: float
    ahead: float
    aside: float
    leaning: float
    seconds: float

    def crossed(self, lengths: float) -> bool:
        """Whether it went so many body lengths without a fall."""
        return self.ahead >= lengths and self.leaning < MOST_LEANING


def cross(scene: str, seed: int, roughness: float, lengths: float, most_seconds: float) -> Crossing:
    """Go over a ground until it is crossed."""
    slope = float(np.random.default_rng(seed).uniform(-STEEPEST, STEEPEST))
    plan = scenes.make(scene, {"slope": slope, "roughness": roughness, "ground_seed": seed})
    options = SimulationOptions(time_step=plan.time_step)
    simulation = Simulation(plan.scene, plan.controller, options=options, fps=FRAMES, name=scene)
    rest = np.asarray(plan.scene.character.mesh.points)
    start = rest.mean(axis=0)
    found = Crossing(slope, 0.0, 0.0, 0.0, 0.0)
    try:
        for frame in simulation.run(most_seconds):
            way = frame.positions.mean(axis=0) - start
            pitch = float(turned(rest, frame.positions[None], 1)[0]) + slope * (way[0] > 1.0)
            found = Crossing(
                slope,
                float(way[0]),
                max(found.aside, abs(float(way[1]))),
                max(found.leaning, abs(pitch)),
                frame.time,
            )
            if found.ahead >= lengths:
                break
    except NotFiniteError:
        return found._replace(leaning=180.0)
    return found


def main() -> None:
    """Print a row a ground, and how many were crossed."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.uneven_grounds")
    parser.add_argument("scene", nargs="?", default="walk-x")
    parser.add_argument("--grounds", type=int, default=20)
    parser.add_argument("--roughness", type=float, default=0.05)
    parser.add_argument("--lengths", type=float, default=10.0)
    parser.add_argument("--seconds", type=float, default=90.0)
    given = parser.parse_args()
    rows, crossed = [], 0
    for seed in range(given.grounds):
        begun = time.process_time()
        found = cross(given.scene, seed, given.roughness, given.lengths, given.seconds)
        crossed += found.crossed(given.lengths)
        rows.append(
            {
                "ground": str(seed),
                "slope": f"{found.slope:.1f}",
                "ahead": f"{found.ahead:.2f}",
                "aside": f"{found.aside:.2f}",
                "leaning": f"{found.leaning:.0f}",
                "seconds": f"{found.seconds:.1f}",
                "CPU, s": f"{time.process_time() - begun:.1f}",
            }
        )
        print(
            as_text(list(rows[0]), [rows[-1].values()], left="ground").splitlines()[-1], flush=True
        )
    print(as_text(list(rows[0]), [row.values() for row in rows], left="ground"))
    print(f"{crossed} of {given.grounds} crossed")


if __name__ == "__main__":
    main()
