"""Whether motions one after the other hold from any start: `python -m benchmarks.sequences`.

    python -m benchmarks.sequences --seeds 10               # ten starts of each body
    python -m benchmarks.sequences letter-x --seeds 3 --rounds 2

A body takes four motions in turn, ten times over. Each seed changes the friction by up to 20 %,
turns the body at the start by up to 6 degrees and tilts it by up to 1, drops it from up to 5 mm,
and pushes it every two seconds, in any direction, by 0.02 body weights for 0.2 s. A run holds where
all motions have ended by themselves and the body ends upright.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.tables import as_text
from warp_softbody import controllers, scenes
from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import Balance, BalanceGains, Crawl, Jump, Leg, Motion, Roll, Walk
from warp_softbody.errors import NotFiniteError
from warp_softbody.run.falls import STANDS, tilt
from warp_softbody.run.simulation import Simulation
from warp_softbody.scenes import roll_o
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import STANDARD_GRAVITY, Push, Scene

FRICTION, FRICTION_CHANGE = 0.8, 0.2
MOST_YAW, MOST_TILT, MOST_DROP = math.radians(6.0), math.radians(1.0), 0.005
PUSH, PUSH_SECONDS, PUSH_EVERY = 0.02, 0.2, 2.0
STEP = 1.0 / 60.0
FRAMES = 10.0  # a second
"""How often it is looked whether the body lies."""
PATIENCE = 2.0
"""Times the usual length of a run, after which a motion that has not ended never will."""


class Programme(NamedTuple):
    """What a body does.

    Attributes:
        body: makes it.
        motions: of a round, that end by themselves.
        seconds: that a round takes about.
        pushed: the region that is pushed.
        may_turn: whether it turns over by rolling, so that it may end with any side up.
    """

    body: Callable[[], Character]
    motions: Callable[[Character], list[Motion]]
    seconds: float
    pushed: str
    may_turn: bool = False


def _letter_h() -> Character:
    return scenes.make("exercise-h").scene.character


def _on_feet(body: Character) -> list[Motion]:
    return [
        Motion(controller=Walk.for_(body), distance=0.5),
        Motion(controller=Jump.for_(body, height=0.05)),
        Motion(controller=Balance.for_(body), seconds=1.0),
        Motion(controller=Walk.for_(body, heading=math.pi), distance=0.25, name="back"),
    ]


def _letter_x() -> Character:
    return scenes.make("walk-x").scene.character


def _walk_and_crawl(body: Character) -> list[Motion]:
    return [
        Motion(controller=Walk.for_(body), distance=0.3),
        Motion(controller=Balance.for_(body), seconds=1.0),
        Motion(controller=Crawl.for_(body), distance=0.1),
        Motion(controller=Walk.for_(body, heading=math.pi), distance=0.2, name="back"),
    ]


def _on_its_rim(body: Character) -> list[Motion]:
    turn = 2.0 * math.pi
    there, back = (
        Roll(roll_o.GAINS, legs=(Leg(direction=way, turn=turn),), rim="rim") for way in (1.0, -1.0)
    )
    gains = BalanceGains(
        upright_weight=0.03, momentum_weight=0.02, spin_weight=0.003, base_weight=0.0
    )
    rim = ("rim-18", "rim-19", "rim-0", "rim-1", "rim-2")
    balance = Balance(gains, base="rim-0", head="rim-10", patches=rim)
    return [
        Motion(controller=there),
        Motion(controller=balance, seconds=1.0),
        Motion(controller=back),
        Motion(controller=balance, seconds=1.0, name="balance again"),
    ]


PROGRAMMES = {
    "letter-h": Programme(_letter_h, _on_feet, 6.5, "head"),
    "letter-x": Programme(_letter_x, _walk_and_crawl, 12.0, "head"),
    "letter-o": Programme(roll_o.rolling_letter, _on_its_rim, 22.0, "rim"),
}


class SequenceEnd(NamedTuple):
    """What came of a run.

    Attributes:
        motions: that have ended.
        wanted: of all rounds.
        seconds: simulated.
        leaning: degrees at the end, and at most.
        now: the motion that was on at the end.
    """

    motions: int
    wanted: int
    seconds: float
    leaning: float
    most: float
    now: str

    @property
    def holds(self) -> bool:
        """Whether all motions were done without a fall."""
        return self.motions == self.wanted and self.leaning < math.degrees(STANDS)


def perturbed(course: Programme, seed: int, seconds: float) -> Scene:
    """The scene of a seed, with pushes for so many seconds."""
    rng = np.random.default_rng(seed)
    body = course.body()
    friction = FRICTION * rng.uniform(1.0 - FRICTION_CHANGE, 1.0 + FRICTION_CHANGE)
    weight = body.material.density * body.mesh.volume * STANDARD_GRAVITY
    return Scene(
        character=body,
        ground=Plane(friction=float(friction)),
        initial_pose=_start(np.asarray(body.mesh.points), rng),
        pushes=_pushes(course.pushed, PUSH * weight, seconds, rng),
    )


def _start(points: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Points (n, 3) m turned, tilted and lifted a little."""
    yaw = rng.uniform(-MOST_YAW, MOST_YAW)
    axis = rng.uniform(0.0, 2.0 * math.pi)
    lean = rng.uniform(0.0, MOST_TILT) * np.array([math.cos(axis), math.sin(axis), 0.0])
    turn = Rotation.from_rotvec(lean) * Rotation.from_rotvec([0.0, 0.0, yaw])
    middle = points.mean(axis=0)
    turned = turn.apply(points - middle) + middle
    turned[:, 2] += rng.uniform(0.0, MOST_DROP) - turned[:, 2].min()
    return np.asarray(turned)


def _pushes(
    region: str, force: float, seconds: float, rng: np.random.Generator
) -> tuple[Push, ...]:
    angles = rng.uniform(0.0, 2.0 * math.pi, int(seconds / PUSH_EVERY))
    starts = PUSH_EVERY * (np.arange(len(angles)) + rng.uniform(0.1, 0.9, len(angles)))
    return tuple(
        Push(
            region=region,
            force=(force * math.cos(angle), force * math.sin(angle), 0.0),
            start=float(start),
            duration=PUSH_SECONDS,
        )
        for angle, start in zip(angles, starts, strict=True)
    )


def go_through(name: str, seed: int, rounds: int) -> SequenceEnd:
    """Take all motions of a course so many times."""
    course = PROGRAMMES[name]
    longest = PATIENCE * course.seconds * rounds
    scene = perturbed(course, seed, longest)
    motions = course.motions(scene.character)
    sequence = controllers.Sequence(motions, rounds=rounds)
    simulation = Simulation(scene, sequence, time_step=STEP, fps=FRAMES, name=name)
    body = scene.character
    found = SequenceEnd(0, rounds * len(motions), 0.0, 0.0, 0.0, "")
    try:
        for frame in simulation.run(longest):
            lean = tilt(body.mesh.points, frame.positions, body.node_masses)
            spans = sequence.course
            found = found._replace(
                motions=found.wanted if sequence.finished else max(0, len(spans) - 1),
                seconds=frame.time,
                leaning=math.degrees(lean),
                most=max(found.most, math.degrees(lean)),
                now=spans[-1].name if spans else "",
            )
            fallen = lean > math.radians(60.0) and not course.may_turn
            if sequence.finished or (fallen and "roll" not in found.now):
                break
    except NotFiniteError:
        return found._replace(leaning=180.0)
    return found


def row_of(name: str, seed: int, found: SequenceEnd, seconds: float) -> dict[str, str]:
    """A row of the table."""
    return {
        "body": name,
        "seed": str(seed),
        "motions": f"{found.motions} of {found.wanted}",
        "seconds": f"{found.seconds:.1f}",
        "leaning": f"{found.leaning:.0f}, {found.most:.0f}",
        "at the end": found.now,
        "CPU, s": f"{seconds:.1f}",
        "holds": "yes" if found.holds else "no",
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a row a run, and how many of each body hold."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.sequences",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bodies", nargs="*", default=list(PROGRAMMES), metavar="BODY")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=0, help="seed of the first run")
    parser.add_argument("--rounds", type=int, default=10)
    given = parser.parse_args(arguments)
    unknown = [name for name in given.bodies if name not in PROGRAMMES]
    if unknown:
        parser.error(f"there is no body {unknown[0]!r}, only {', '.join(PROGRAMMES)}")
    rows: list[dict[str, str]] = []
    for name in given.bodies:
        for seed in range(given.first, given.first + given.seeds):
            begun = time.process_time()
            found = go_through(name, seed, given.rounds)
            rows.append(row_of(name, seed, found, time.process_time() - begun))
            print(" | ".join(rows[-1].values()), flush=True)
    print(as_text(list(rows[0]), [row.values() for row in rows], left="body"))
    for name in given.bodies:
        own = [row for row in rows if row["body"] == name]
        print(f"{name}: {sum(row['holds'] == 'yes' for row in own)} of {len(own)} hold")


if __name__ == "__main__":
    main()
