"""A scene as a Gymnasium environment."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any, Literal

import gymnasium
import numpy as np
import numpy.typing as npt

from warp_softbody.engine.options import SimulationOptions
from warp_softbody.environment.episode import (
    Ends,
    Episode,
    Observation,
    Reward,
    SavedEpisode,
    progress,
    require_begun,
)
from warp_softbody.environment.senses import LARGEST
from warp_softbody.errors import InputError, NotFiniteError
from warp_softbody.inputs import checks
from warp_softbody.run.simulation import Simulation
from warp_softbody.stage_exports.pictures.still_frame import FramePainter
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

Action = npt.NDArray[np.float32]
Muscles = Literal["fibers", "segments"]
Space = gymnasium.spaces.Box[np.float32]

MOST_STEPS = 1000


class Environment(gymnasium.Env[Observation, Action]):
    """A character that learns to use its muscles.

    An action is a contraction of each muscle from 0, slack, to 1, half its length; it is held for
    some time steps. What is observed is told by `Senses`. ``info`` has the time, s.

    Attributes:
        simulation: what is stepped; its pushes, forces and observers are the scene's and yours.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 30}  # noqa: RUF012

    def __init__(
        self,
        scene: Scene,
        *,
        reward: Reward | None = None,
        ends: Ends | None = None,
        seconds: float = 5.0,
        time_step: float = 1.0 / 60.0,
        steps: int = 4,
        muscles: Muscles = "fibers",
        start_speed: float = 0.0,
        options: SimulationOptions | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Make the environment of a scene without a controller.

        Args:
            scene: what there is; its character's muscles are acted on.
            reward: of the views before and after an action; None for the way along x over the
                body's length.
            ends: whether a view ends the episode, as that of a body that has fallen.
            seconds: after which an episode is cut off.
            time_step: s.
            steps: time steps that an action is held for.
            muscles: "fibers", whose segments contract alike, or "segments".
            start_speed: m/s, greatest random horizontal velocity at the start.
            options: of the engine.
            render_mode: "rgb_array" for pictures; None for none.
        """
        episode = made_episode(scene, reward, ends, seconds, time_step, steps, muscles, options)
        self._steps = steps
        self._begun = False
        self._start_speed = checks.number(
            "start_speed of an Environment", start_speed, low=0.0, unit="m/s"
        )
        if render_mode is not None:
            checks.choice("render_mode of an Environment", render_mode, ("rgb_array",))
        self.render_mode = render_mode
        self._episode = episode
        self.simulation = episode.simulation
        actions, observations = spaces_of(episode)
        self.action_space: gymnasium.Space[Action] = actions
        self.observation_space: gymnasium.Space[Observation] = observations
        self._watchers: list[Callable[[Frame], object]] = []
        self._painter: FramePainter | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; the same seed gives the same bits."""
        super().reset(seed=seed)
        seen = self._episode.begin(self.np_random, self._start_speed)
        self._begun = True
        self._show()
        return seen, self._info()

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold an action for some time steps.

        A body that numbers fail on ends its episode without a reward.

        Raises:
            InputError: nothing has been reset or restored since the environment was made or closed,
                the action is none, the reward is no finite number, or the scene cannot go on.
        """
        require_begun(self._begun, "an Environment")
        self._episode.act(action)
        failed = False
        try:
            for _ in range(self._steps):
                self.simulation.step()
        except NotFiniteError:
            failed = True
        if self._watchers and not failed:
            self._show()
        return (*self._episode.outcome(failed=failed), self._info())

    def close(self) -> None:
        """End the episode; a `reset` starts another one."""
        self._begun = False
        super().close()

    def save(self) -> SavedEpisode:
        """Where the episode is, from which `restore` goes on to the last bit."""
        return SavedEpisode(
            motion=self.simulation.save(),
            steps=self._steps,
            muscles=self._episode.senses.muscles,
            taken=self._episode.taken,
            random=copy.deepcopy(dict(self.np_random.bit_generator.state)),
        )

    def restore(self, saved: SavedEpisode) -> Observation:
        """Go on from where the episode was; what is observed there.

        Raises:
            InputError: it is of another scene, or of other actions.
        """
        saved = checks.instance("saved of Environment.restore", saved, SavedEpisode)
        if saved.steps != self._steps:
            raise InputError(
                f"an episode of actions held for {saved.steps} steps cannot be restored by an "
                f"Environment with steps={self._steps}"
            )
        if not np.array_equal(saved.muscles, self._episode.senses.muscles):
            raise InputError(
                "an episode cannot be restored by an Environment of other muscles: it was "
                f"{int(saved.muscles[-1]) + 1} of them that acted, here it is "
                f"{int(self._episode.senses.muscles[-1]) + 1}"
            )
        self.simulation.restore(saved.motion)
        self._begun = True
        self._episode.taken = saved.taken
        self.np_random.bit_generator.state = copy.deepcopy(saved.random)
        return self._episode.look()

    def watch(self, show: Callable[[Frame], object]) -> None:
        """Hand the frame of every reset and action to a function, such as `StageWriter.write`."""
        checks.called_with("show of Environment.watch", show, 1, "a function of a Frame")
        self._watchers.append(show)

    def render(self) -> npt.NDArray[np.uint8] | None:
        """A picture (height, width, 3) of the body as it is; None without a render mode."""
        if self.render_mode is None:
            return None
        if self._painter is None:
            self._painter = FramePainter(self.simulation.model.scene)
        return self._painter.draw(self.simulation.frame())

    def _show(self) -> None:
        if self._watchers:
            frame = self.simulation.frame()
            for show in self._watchers:
                show(frame)

    def _info(self) -> dict[str, Any]:
        return {"time": self.simulation.time}


def made_episode(
    scene: Scene,
    reward: Reward | None,
    ends: Ends | None,
    seconds: float,
    time_step: float,
    steps: int,
    muscles: str,
    options: SimulationOptions | None,
    simulation: Simulation | None = None,
) -> Episode:
    """The episodes of one body, with all arguments checked.

    Raises:
        InputError: an argument is none, or the character has no muscles.
    """
    checks.instance("scene of an Environment", scene, Scene)
    if not scene.character.muscles:
        raise InputError(
            f"an Environment needs muscles, but character {scene.character.name!r} has none"
        )
    if reward is None:
        reward = progress
    checks.called_with("reward of an Environment", reward, 2, "a function of two views")
    if ends is not None:
        checks.called_with("ends of an Environment", ends, 1, "a function of a view")
    seconds = checks.number("seconds of an Environment", seconds, above=0.0, unit="s")
    steps = checks.whole("steps of an Environment", steps, low=1, high=MOST_STEPS)
    checks.choice("muscles of an Environment", muscles, ("fibers", "segments"))
    if simulation is None:
        fps = 1.0 / (checks.number("time_step of an Environment", time_step, above=0.0) * steps)
        simulation = Simulation(
            scene, options=options, time_step=time_step, fps=fps, name="environment", timed=False
        )
    held = simulation.model.options.time_step * steps
    return Episode(simulation, muscles, reward, ends, max(1, round(seconds / held)))


def spaces_of(
    episode: Episode,
) -> tuple[gymnasium.spaces.Box[np.float32], gymnasium.spaces.Box[np.float32]]:
    """Of the actions and of the observations."""
    muscles = int(episode.senses.muscles[-1]) + 1
    return (
        gymnasium.spaces.Box(0.0, 1.0, (muscles,), np.float32),
        gymnasium.spaces.Box(-LARGEST, LARGEST, (episode.senses.count,), np.float32),
    )
