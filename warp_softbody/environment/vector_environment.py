"""Many copies of an environment, stepped side by side as a `Batch`."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from warp_softbody.engine.options import SimulationOptions
from warp_softbody.environment.environment import Muscles, made_episode, spaces_of
from warp_softbody.environment.episode import Ends, Observation, Reward, require_begun
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.run.batch import Batch
from warp_softbody.run.batch_member import Vary
from warp_softbody.world.scene import Scene

Numbers = npt.NDArray[np.float64]
Truths = npt.NDArray[np.bool_]


class VectorEnvironment(VectorEnv[Observation, npt.NDArray[np.float32], npt.NDArray[Any]]):
    """Environments of one scene, which may differ in pushes, materials and the like.

    An environment whose episode has ended starts anew in the next step, whose action it ignores and
    whose reward is zero (Gymnasium's ``NEXT_STEP``). Every one gives the bits of an `Environment`.

    Attributes:
        batch: of the simulations.
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        scene: Scene,
        count: int,
        vary: Vary | None = None,
        *,
        threads: int = 1,
        reward: Reward | None = None,
        ends: Ends | None = None,
        seconds: float = 5.0,
        time_step: float = 1.0 / 60.0,
        steps: int = 4,
        muscles: Muscles = "fibers",
        start_speed: float = 0.0,
        options: SimulationOptions | None = None,
    ) -> None:
        """Make ``count`` environments of a scene.

        Args:
            scene: as of an `Environment`.
            count: of environments.
            vary: gives each what it has of its own, as of a `Batch`; no controllers.
            threads: that step them side by side.
            reward: as of an `Environment`, as are the others.
            ends: as of an `Environment`.
            seconds: as of an `Environment`.
            time_step: s.
            steps: time steps that an action is held for.
            muscles: "fibers" or "segments".
            start_speed: m/s.
            options: of the engine.
        """
        steps = checks.whole("steps of an Environment", steps, low=1, high=1000)
        time_step = checks.number("time_step of an Environment", time_step, above=0.0, unit="s")
        self._start_speed = checks.number(
            "start_speed of an Environment", start_speed, low=0.0, unit="m/s"
        )
        self.batch = Batch(
            scene,
            count,
            vary,
            threads=threads,
            options=options,
            time_step=time_step,
            fps=1.0 / (time_step * steps),
            name="environment",
        )
        self._steps = steps
        self._episodes = [
            made_episode(scene, reward, ends, seconds, time_step, steps, muscles, options, member)
            for member in self.batch
        ]
        self.num_envs = len(self.batch)
        self.single_action_space, self.single_observation_space = spaces_of(self._episodes[0])
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self._random = [np.random.default_rng(index) for index in range(self.num_envs)]
        self._over = np.zeros(self.num_envs, dtype=bool)
        self._begun = False

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Start all episodes; environment i has the random numbers of seed + i.

        Raises:
            InputError: there is another number of seeds than of environments.
        """
        for index, own in enumerate(self._seeds(seed)):
            if own is not None:
                self._random[index] = gymnasium.utils.seeding.np_random(own)[0]
        self._over[:] = False
        self._begun = True
        seen = [self._begin(index) for index in range(self.num_envs)]
        return np.stack(seen), self._info()

    def step(
        self, actions: npt.ArrayLike
    ) -> tuple[Observation, Numbers, Truths, Truths, dict[str, Any]]:
        """Hold an action (count, muscles) for some time steps.

        Raises:
            InputError: nothing has been reset since the environments were made or closed, an action
                is none, or a reward is no finite number.
        """
        require_begun(self._begun, "a VectorEnvironment")
        given = np.asarray(actions)
        if given.shape != self.action_space.shape:
            raise InputError(
                f"actions of a VectorEnvironment must be of shape {self.action_space.shape}, "
                f"not {given.shape}"
            )
        over, self._over = self._over, np.zeros(self.num_envs, dtype=bool)
        for episode, action, is_over in zip(self._episodes, given, over, strict=True):
            if not is_over:
                episode.act(action)
        with self.batch.without(index for index, is_over in enumerate(over) if is_over):
            for _ in range(self._steps):
                self.batch.step()
        seen = np.empty(self.observation_space.shape or (), dtype=np.float32)
        rewards = np.zeros(self.num_envs)
        terminated, truncated = (np.zeros(self.num_envs, dtype=bool) for _ in range(2))
        for index, episode in enumerate(self._episodes):
            if over[index]:
                seen[index] = self._begin(index)
                continue
            outcome = episode.outcome(failed=index in self.batch.failures)
            seen[index], rewards[index], terminated[index], truncated[index] = outcome
        self._over = terminated | truncated
        return seen, rewards, terminated, truncated, self._info()

    def _seeds(self, given: int | list[int | None] | None) -> list[int | None]:
        """Of each environment."""
        if given is None:
            return [None] * self.num_envs
        if isinstance(given, int | np.integer):
            return [int(given) + index for index in range(self.num_envs)]
        if len(given) != self.num_envs:
            raise InputError(
                f"seed of a VectorEnvironment must be one number or {self.num_envs} of them, "
                f"not {len(given)}"
            )
        return list(given)

    def close_extras(self, **kwargs: Any) -> None:
        """End all episodes."""
        self._begun = False

    def _begin(self, index: int) -> Observation:
        self.batch.revive(index)
        return self._episodes[index].begin(self._random[index], self._start_speed)

    def _info(self) -> dict[str, Any]:
        return {"time": np.array([member.time for member in self.batch])}
