"""Many copies of a scene that never touch, stepped side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from types import MappingProxyType
from typing import TypeAlias

from warp_softbody.controllers.control_options import ControlOptions, Method
from warp_softbody.device.turns import shares_warp
from warp_softbody.device.workspace import Workspace
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

ENDED = object()
"""In place of a frame where a run has come to its end."""

Work: TypeAlias = Callable[[list[int]], object]
"""What is done with the members of some indices."""


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
                its own: another scene of the same meshes, controllers; None for copies.
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
        # a thread's members step in turn, and so may work in the same arrays
        workspaces = [Workspace() for _ in range(self.threads)]
        self._simulations: list[Simulation] = []
        for index, member in enumerate(members):
            self._simulations.append(
                Simulation(
                    member.scene,
                    member.controller,
                    others=member.others,
                    options=options,
                    control_options=control_options,
                    time_step=time_step,
                    fps=fps,
                    method=method,
                    name=f"{name} {index}",
                    like=self._simulations[0].model if self._simulations else None,
                    timed=False,
                    workspace=workspaces[index % self.threads],
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

    def revive(self, index: int) -> None:
        """Let a member that has failed or was left take steps again, from a motion restored."""
        index = checks.whole("index of Batch.revive", index, high=len(self) - 1)
        self._left.discard(index)
        self._failures.pop(index, None)

    @contextmanager
    def without(self, indices: Iterable[int]) -> Iterator[None]:
        """Leave some running members for the length of a `with` body."""
        aside = {
            checks.whole("an index of Batch.without", index, high=len(self) - 1)
            for index in indices
        } - self._left
        self._left |= aside
        try:
            yield
        finally:
            self._left -= aside

    def step(self) -> None:
        """Advance every running member by one time step.

        An error that ends a member's run is kept in `failures`; others, such as those of a
        controller's own code, end the batch.
        """
        with self._workers() as side_by_side:
            side_by_side(self._step)

    def run(self, seconds: float) -> Iterator[tuple[Frame | None, ...]]:
        """The members' frames at t = 0, 1/fps, ... up to ``seconds``.

        None stands for the frame of a member that has failed or was left.
        """
        seconds = checks.number("seconds of a run", seconds, above=0.0, unit="s")
        return self._frames_until(seconds)

    def _frames_until(self, seconds: float) -> Iterator[tuple[Frame | None, ...]]:
        runs = [simulation.schedule(seconds) for simulation in self._simulations]
        with self._workers() as side_by_side:
            while True:
                frames: list[Frame | None] = [None] * len(self)

                def go_on(share: list[int], frames: list[Frame | None] = frames) -> None:
                    while share:
                        frame_or_step = {index: next(runs[index], ENDED) for index in share}
                        for index, item in frame_or_step.items():
                            frames[index] = item if isinstance(item, Frame) else None
                        share = self._step([i for i, item in frame_or_step.items() if item is None])

                side_by_side(go_on)
                if all(frame is None for frame in frames):
                    return
                yield tuple(frames)

    @shares_warp
    def _step(self, share: list[int]) -> list[int]:
        """Take a step of some members; those that go on."""
        for take in (Simulation.begin_step, Simulation.end_step):
            going = []
            for index in share:
                try:
                    take(self._simulations[index])
                except SoftBodyError as error:
                    self._failures[index] = error
                else:
                    going.append(index)
            share = going
        return share

    @contextmanager
    def _workers(self) -> Iterator[Callable[[Work], None]]:
        """What does some work on each share of the running members, in a thread of its own."""

        def alone(work: Work) -> None:
            work(self._share(0))

        if self.threads == 1:
            yield alone
            return
        with ThreadPoolExecutor(self.threads, thread_name_prefix="batch") as pool:

            def side_by_side(work: Work) -> None:
                shares = map(self._share, range(self.threads))
                futures = [pool.submit(work, share) for share in shares]
                for future in futures:
                    future.result()

            yield side_by_side

    def _share(self, thread: int) -> list[int]:
        """Running members of a thread, which have its workspace."""
        return [index for index in self.running if index % self.threads == thread]

    def summaries(self) -> tuple[RunSummary, ...]:
        """The run of each member so far in numbers."""
        return tuple(simulation.summary() for simulation in self._simulations)
