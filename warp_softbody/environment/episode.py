"""One body in one environment: from actions to steps, and from steps to rewards."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.environment.senses import Senses
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.run.saved_motion import SavedMotion
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.view import BodyView

Observation = npt.NDArray[np.float32]
Reward = Callable[[BodyView, BodyView], float]
Ends = Callable[[BodyView], bool]

CONTRACTION = 0.5
"""By which a muscle is shortened by an action of one, over its length at rest."""


def progress(before: BodyView, after: BodyView) -> float:
    """Way along x in one step of an environment, over the body's length."""
    way = after.center_of_mass[0] - before.center_of_mass[0]
    return float(way) / BodyUnits.of(after).length


@dataclass(frozen=True, eq=False, repr=False)
class SavedEpisode:
    """Where an environment is, for `Environment.restore`.

    Attributes:
        motion: of the body.
        steps: time steps that an action is held for.
        muscles: (segments,) which muscle each segment belongs to.
        taken: actions since the reset.
        random: state of the random numbers.
    """

    motion: SavedMotion
    steps: int
    muscles: npt.NDArray[np.intp]
    taken: int
    random: dict[str, Any]


class Episode:
    """Acts on a simulation and tells what comes of it.

    Attributes:
        simulation: of the body.
        senses: what is observed.
        taken: actions since the reset.
    """

    def __init__(
        self, simulation: Simulation, muscles: str, reward: Reward, ends: Ends | None, actions: int
    ) -> None:
        """Episodes of so many ``actions`` in a simulation that has not begun."""
        self.simulation = simulation
        self.senses = Senses(simulation, muscles)
        self.taken = 0
        segments = self.senses.muscles
        self._shape = (int(segments[-1]) + 1 if len(segments) else 0,)
        self._reward, self._ends, self._actions = reward, ends, actions
        self._first = simulation.save()
        self._length = BodyUnits.of_scene(simulation.model.scene).length
        # what was observed has the way along x already
        self._looks = reward is not progress or ends is not None
        self._view: BodyView | None = None
        self.look()

    def begin(self, random: np.random.Generator, start_speed: float) -> Observation:
        """Start anew, with a random horizontal velocity of at most a speed, m/s."""
        self.simulation.restore(self._first)
        self.taken = 0
        if start_speed > 0.0:
            angle, speed = random.uniform(-np.pi, np.pi), random.uniform(0.0, start_speed)
            velocities = self.simulation.state.velocities
            moved = velocities.numpy() + speed * np.array([np.cos(angle), np.sin(angle), 0.0])
            velocities.assign(moved.astype(velocities.numpy().dtype))
        return self.look()

    def look(self) -> Observation:
        """What is observed now, from which the next reward counts."""
        if self._looks:
            self._view = self.simulation.view()
        seen = self.senses.observe()
        self._seen, self._ahead = seen.copy(), self.senses.ahead
        return seen

    def act(self, action: npt.ArrayLike) -> None:
        """Contract the muscles, (muscles,) from 0 to 1, until the next action."""
        given = array_checks.array("action of an Environment", action, self._shape)
        try:
            self.simulation.drive(1.0 - CONTRACTION * given[self.senses.muscles])
        except InputError:
            # it looks at all activations anyway
            raise InputError(
                "action of an Environment must hold contractions from 0 to 1, "
                f"not {given.min():.4g} to {given.max():.4g}"
            ) from None

    def outcome(self, *, failed: bool) -> tuple[Observation, float, bool, bool]:
        """Observation, reward, and whether the episode is terminated or truncated."""
        self.taken += 1
        if failed:
            return self._seen.copy(), 0.0, True, False
        before, ahead = self._view, self._ahead
        seen = self.look()
        if before is None or self._view is None:
            reward, ended = (self._ahead - ahead) / self._length, False
        else:
            reward = _checked(self._reward(before, self._view))
            ended = self._ends is not None and bool(self._ends(self._view))
        return seen, reward, ended, not ended and self.taken >= self._actions


def _checked(reward: object) -> float:
    """A finite reward; truth values count as 0 and 1."""
    given = float(reward) if isinstance(reward, bool | np.bool_) else reward
    return checks.number("what the reward of an Environment returns", given)


def require_begun(begun: bool, of: str) -> None:
    """Refuse a step before there is an episode.

    Raises:
        InputError: nothing has begun; ``of`` names the environment.
    """
    if not begun:
        raise InputError(f"step of {of} needs a reset first: no episode has begun, or it is closed")
