"""Many copies of a scene that never touch, stepped side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from types import MappingProxyType
from typing import TypeAlias

from warp_softbody.controllers.control_options import ControlOptions, Method
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.errors import SoftBodyError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.run.batch_member import Vary, members_of
from warp_softbody.run.run_summary import RunSummary
from warp_softbody.run.simulation import Simulation
from warp_softbody.world.frame import Frame
from warp_softbody.world.scene import Scene

MOST_MEMBERS = 1_000_000
MOST_THREADS = 1024

Advance: TypeAlias = Callable[[int], None]
"""Takes the member of an index on."""


class Batch:
    """Simulations of one scene, each with a state, pushes, materials and a controller of its own.

    Members share what is constant: index arrays, rest shape, muscle weights and the pattern of the
    factor. Every member takes the steps that it would take alone, to the last bit, whatever the
    others do and however many threads there are.

    ``batch[i]`` is the `Simulation` of member i, ``len(batch)`` their number.

    Attributes:
        fps: frames per simulated second.
        threads: that step members side by side.
        failures: the error that ended a member's run, by its index; the others go on.
    """

    def __init__(
        self,
        scene: Scene,
        count: int,
        vary: Vary | None = None,
        *,
        seed: int = 0,
        threads: int = 1,
        options: SimulationOptions | None = None,
        control_options: ControlOptions | None = None,
        time_step: float | None = None,
        fps: float = 30.0,
        method: Method | None = None,
        name: str = "batch",
    ) -> None:
        """Build the members.

        Args:
            scene: what all members begin with.
            count: number of members.
            vary: called once for each `BatchMember` in turn, and returns it with what it has of
                its own: another scene of the same meshes, a controller; None for copies.
            seed: of the members' random numbers.
            threads: that step members side by side; as many as there are cores pay.
            options: of every `Simulation`, as are the next four.
            control_options: of their control solvers.
            time_step: s, in place of that of the options.
            fps: frames per simulated second.
            method: in place of that of the control options.
            name: of the batch; member i is called "name i" in what is told of its run.
        """
        checks.instance("scene of a Batch", scene, Scene)
        count = checks.whole("count of a Batch", count, low=1, high=MOST_MEMBERS)
        if vary is not None:
            wanted = "a function of a BatchMember that returns one"
            checks.called_with("vary of a Batch", vary, 1, wanted)
        seed = checks.whole("seed of a Batch", seed)
        self.threads = checks.whole("threads of a Batch", threads, low=1, high=MOST_THREADS)
        input_kinds.name("name of a Batch", name)
        members = members_of(scene, count, vary, seed)
        self._simulations: list[Simulation] = []
        for member in members:
            self._simulations.append(
                Simulation(
                    member.scene,
                    member.controller,
                    options=options,
                    control_options=control_options,
                    time_step=time_step,
                    fps=fps,
                    method=method,
                    name=f"{name} {member.index}",
                    like=self._simulations[0].model if self._simulations else None,
                    timed=False,
                )
            )
        self.fps = self._simulations[0].fps
        self._failures: dict[int, SoftBodyError] = {}
        self._left: set[int] = set()

    def __len__(self) -> int:
        """Number of members."""
        return len(self._simulations)

    def __getitem__(self, index: int) -> Simulation:
        """A member's simulation."""
        return self._simulations[index]

    def __iter__(self) -> Iterator[Simulation]:
        """The members' simulations in their order."""
        return iter(self._simulations)

    @property
    def failures(self) -> Mapping[int, SoftBodyError]:
        """The error that ended a member's run, by its index."""
        return MappingProxyType(self._failures)

    @property
    def running(self) -> tuple[int, ...]:
        """Indices of the members that still take steps."""
        apart = self._left | self._failures.keys()
        return tuple(index for index in range(len(self)) if index not in apart)

    def leave(self, index: int) -> None:
        """Let a member take no more steps; what it has come to stays."""
        index = checks.whole("index of Batch.leave", index, high=len(self) - 1)
        self._left.add(index)

    def step(self) -> None:
        """Advance every running member by one time step.

        An error that ends a member's run is kept in `failures`; others, such as those of a
        controller's own code, end the batch.
        """
        with self._workers() as advance_all:
            advance_all(lambda index: self._simulations[index].step())

    def run(self, seconds: float) -> Iterator[tuple[Frame | None, ...]]:
        """The members' frames at t = 0, 1/fps, ... up to ``seconds``.

        None stands for the frame of a member that has failed or was left.
        """
        seconds = checks.number("seconds of a run", seconds, above=0.0, unit="s")
        return self._frames_until(seconds)

    def _frames_until(self, seconds: float) -> Iterator[tuple[Frame | None, ...]]:
        runs = [simulation.run(seconds) for simulation in self._simulations]
        ended = object()
        with self._workers() as advance_all:
            while self.running:
                frames: list[Frame | object | None] = [None] * len(self)

                def take(index: int, frames: list[Frame | object | None] = frames) -> None:
                    frames[index] = next(runs[index], ended)

                advance_all(take)
                if ended in frames:
                    return
                yield tuple(frame if isinstance(frame, Frame) else None for frame in frames)

    @contextmanager
    def _workers(self) -> Iterator[Callable[[Advance], None]]:
        """A function that takes every running member on, in threads where there are several."""
        if self.threads == 1:
            yield lambda advance: self._advance(advance, self.running)
            return
        with ThreadPoolExecutor(self.threads, thread_name_prefix="batch") as pool:

            def side_by_side(advance: Advance) -> None:
                shares = [self.running[first :: self.threads] for first in range(self.threads)]
                futures = [pool.submit(self._advance, advance, share) for share in shares]
                for future in futures:
                    future.result()

            yield side_by_side

    def _advance(self, advance: Advance, indices: tuple[int, ...]) -> None:
        for index in indices:
            try:
                advance(index)
            except SoftBodyError as error:
                self._failures[index] = error

    def summaries(self) -> tuple[RunSummary, ...]:
        """The run of each member so far in numbers."""
        return tuple(simulation.summary() for simulation in self._simulations)
