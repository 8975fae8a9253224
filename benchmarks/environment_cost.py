"""What an `Environment` adds to a `Simulation`: ``python -m benchmarks.environment_cost``.

Both take the same steps under the same contractions, to the last bit, in turn in one process and a
few actions at a time. The ratio is the median over the turns of that of their CPU times.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.beam.arguments import count
from benchmarks.tables import as_text
from warp_softbody import characters
from warp_softbody.body.character import Character
from warp_softbody.environment.environment import Environment
from warp_softbody.environment.episode import CONTRACTION
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STEPS = 4
IN_TURN = 10
BODIES: tuple[tuple[str, Callable[[], Character]], ...] = (
    ("letter_i, coarse", lambda: characters.letter_i(coarse=1)),
    ("letter_i_flat", characters.letter_i_flat),
    ("letter_x", characters.letter_x),
)
STRENGTHS = (0.0, 0.1, 1.0)
"""Greatest contraction: none leaves the cheapest steps that there are, those of a body at rest."""


@dataclass(frozen=True)
class Cost:
    """Of one body under contractions of one strength.

    Attributes:
        step: ms of CPU time, of a `Simulation`.
        ratio: of an `Environment` to it.
        same: whether both ended in the same place.
    """

    step: float
    ratio: float
    same: bool


def cost(character: Character, strength: float, steps: int) -> Cost:
    """Measure over some steps, after as many turns as make both warm."""
    scene = Scene(character=character, ground=Plane())
    turns = max(1, steps // (STEPS * IN_TURN))
    environment = Environment(scene, seconds=1e6, steps=STEPS)
    environment.reset(seed=0)
    options = environment.simulation.model.options
    fps = 1.0 / (options.time_step * STEPS)
    bare = Simulation(scene, time_step=options.time_step, fps=fps, timed=False)
    sizes = [fiber.segment_count for fiber in character.fibers]
    segments = np.repeat(np.arange(len(sizes)), sizes)
    numbers = np.random.default_rng(0).uniform(0.0, strength, (turns + 1, IN_TURN, len(sizes)))
    actions = numbers.astype(np.float32)

    def acting(turn: int) -> None:
        for action in actions[turn]:
            environment.step(action)

    def stepping(turn: int) -> None:
        for action in actions[turn]:
            bare.drive(1.0 - CONTRACTION * action.astype(float)[segments])
            for _ in range(STEPS):
                bare.step()

    acting(0)
    stepping(0)
    spent = np.array([_in_turn(acting, stepping, turn) for turn in range(1, turns + 1)])
    same = np.array_equal(
        environment.simulation.state.positions.numpy(), bare.state.positions.numpy()
    )
    ratio = float(np.median(spent[:, 0] / spent[:, 1]))
    return Cost(1e3 * float(np.median(spent[:, 1])) / (STEPS * IN_TURN), ratio, same)


def _in_turn(
    acting: Callable[[int], None], stepping: Callable[[int], None], turn: int
) -> tuple[float, float]:
    """CPU times of both, each of them first in every other turn."""
    order = [(0, acting), (1, stepping)]
    spent = [0.0, 0.0]
    for side, run in order if turn % 2 else reversed(order):
        begun = time.process_time()
        run(turn)
        spent[side] = time.process_time() - begun
    return spent[0], spent[1]


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, prog="python -m benchmarks.environment_cost"
    )
    parser.add_argument("--steps", type=count, default=1000, help="of each side (1000)")
    steps = parser.parse_args(arguments).steps
    rows = []
    for name, make in BODIES:
        for strength in STRENGTHS:
            found = cost(make(), strength, steps)
            rows.append([name, f"{strength:g}", f"{found.step:.2f}", f"{found.ratio:.3f}"])
    titles = ["body", "greatest contraction", "ms a step", "Environment/Simulation"]
    print(as_text(titles, rows, left="body"))


if __name__ == "__main__":
    main()
