"""How many random grounds a body crosses: `python -m benchmarks.uneven_grounds walk-x crawl-i`.

Ground k has a slope between -15 and 15 degrees, hills of its own, 5 % of the body's length from the
deepest valley to the highest top, steps of 5 % up and down across the way, and stripes that lack up
to half of the friction. It is crossed where the centre of mass comes ten body lengths ahead in time
while the body never leans by more than 45 degrees against the ground's slope.

Crawling has a friction of 0.4 and stripes that lack up to 0.3 of it: what is below the tangent of
the slope, 0.27 at 15 degrees, holds no body that lies, so that it would slide down instead.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
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
SLIPPERY = {"crawl-i": {"friction": 0.4, "friction_stripes": 0.3}}
"""Settings of scenes that need other friction than the usual one."""
MOST_SECONDS = {"crawl-i": 240.0}


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


def settings_of(scene: str, seed: int, given: argparse.Namespace) -> dict[str, float]:
    """Those of ground ``seed``."""
    slope = float(np.random.default_rng(seed).uniform(-given.slope, given.slope))
    found = {name: getattr(given, name) for name in ("roughness", "steps", "friction_stripes")}
    found |= SLIPPERY.get(scene, {}) if given.friction_stripes else {}
    if given.friction is not None:
        found["friction"] = given.friction
    return {**found, "slope": slope, "ground_seed": seed}


def cross(scene: str, settings: dict[str, float], lengths: float, most_seconds: float) -> Crossing:
    """Go over a ground until it is crossed."""
    slope = settings["slope"]
    plan = scenes.make(scene, settings)
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


def row_of(scene: str, seed: int, found: Crossing, seconds: float) -> dict[str, str]:
    """A row of the table."""
    return {
        "scene": scene,
        "ground": str(seed),
        "slope": f"{found.slope:.1f}",
        "ahead": f"{found.ahead:.2f}",
        "aside": f"{found.aside:.2f}",
        "leaning": f"{found.leaning:.0f}",
        "seconds": f"{found.seconds:.1f}",
        "CPU, s": f"{seconds:.1f}",
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a row a ground, and how many were crossed."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.uneven_grounds",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("scenes", nargs="*", default=["walk-x", "crawl-i"], metavar="SCENE")
    parser.add_argument("--grounds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first ground")
    parser.add_argument("--slope", type=float, default=STEEPEST, help="degrees, up and down")
    parser.add_argument("--roughness", type=float, default=0.05)
    parser.add_argument("--steps", type=float, default=0.05)
    parser.add_argument("--friction-stripes", type=float, default=0.5)
    parser.add_argument("--friction", type=float, help="in place of the scene's own")
    parser.add_argument("--lengths", type=float, default=10.0)
    parser.add_argument("--seconds", type=float, help="in which a ground is to be crossed")
    given = parser.parse_args(arguments)
    rows, crossed = [], dict.fromkeys(given.scenes, 0)
    for scene in given.scenes:
        most = given.seconds or MOST_SECONDS.get(scene, 90.0)
        for seed in range(given.first, given.first + given.grounds):
            begun = time.process_time()
            found = cross(scene, settings_of(scene, seed, given), given.lengths, most)
            crossed[scene] += found.crossed(given.lengths)
            rows.append(row_of(scene, seed, found, time.process_time() - begun))
            print(" | ".join(rows[-1].values()), flush=True)
    print(as_text(list(rows[0]), [row.values() for row in rows], left="scene"))
    for scene, count in crossed.items():
        print(f"{scene}: {count} of {given.grounds} crossed")


if __name__ == "__main__":
    main()
