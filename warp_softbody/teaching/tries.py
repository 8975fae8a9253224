"""Tries of a task: how far a body comes with some gains, and what that costs in a search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from warp_softbody.arrays import FloatArray
from warp_softbody.body.lessons import Lesson
from warp_softbody.run.batch import Batch
from warp_softbody.run.batch_member import BatchMember
from warp_softbody.run.falls import LIES, tilt
from warp_softbody.teaching.task import Task
from warp_softbody.world.frame import Frame
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

FPS = 10.0
"""Looks a second at a body that tries."""

SUNK = 0.72
"""Of the first height of the centre of mass: a body that is lower has fallen."""

FALLING, FELL = 2.0, 0.25
"""What it costs to fall at once, over what it costs to fall at the very end, in body lengths."""

ASIDE = 0.5
"""Of the way that a body goes to the side, by how much it counts against the one ahead."""


class Try(NamedTuple):
    """What came of some gains on the ground where they did worst.

    Attributes:
        way: along x, over the body's length, as long as it did not fall.
        aside: to the side of it, likewise, without its sign.
        lasted: share of the time until it fell; 1 where it did not.
    """

    way: float
    aside: float
    lasted: float

    @property
    def fell(self) -> bool:
        """Whether it fell."""
        return self.lasted < 1.0

    @property
    def cost(self) -> float:
        """Less is better; standing still costs nothing."""
        fall = FELL + FALLING * (1.0 - self.lasted) if self.fell else 0.0
        return fall + ASIDE * self.aside - self.way


@dataclass
class _Watch:
    """Of one run: where it began, where it is, and when it fell."""

    start: FloatArray
    last: FloatArray
    fell: float | None = None


def make_tries(task: Task, lessons: Sequence[Lesson]) -> list[Try]:
    """Try each lesson on every ground, as one batch; what each came to."""
    scene = Scene(character=task.character, ground=Plane(friction=task.frictions[0]))
    grounds = len(task.frictions)

    def own(member: BatchMember) -> BatchMember:
        friction = task.frictions[member.index % grounds]
        return replace(
            member,
            scene=replace(scene, ground=Plane(friction=friction)),
            controller=task.controller(lessons[member.index // grounds]),
        )

    count = len(lessons) * grounds
    batch = Batch(scene, count, own, time_step=task.time_step, fps=FPS, name="try")
    watches: list[_Watch | None] = [None] * count
    for frames in batch.run(task.seconds):
        for index, frame in enumerate(frames):
            if frame is not None:
                now = watches[index] = _seen(task, watches[index], frame)
                if now.fell is not None:
                    batch.leave(index)
    for index in batch.failures:
        watch = watches[index]
        if watch is not None and watch.fell is None:
            watch.fell = 0.0
    found = [_judged(task, watch) for watch in watches]
    return [
        max(found[first : first + grounds], key=lambda one: one.cost)
        for first in range(0, count, grounds)
    ]


def _seen(task: Task, watch: _Watch | None, frame: Frame) -> _Watch:
    masses = task.character.node_masses
    middle = masses @ frame.positions / masses.sum()
    if watch is None:
        return _Watch(start=middle, last=middle)
    leans = task.do != "roll" and tilt(task.character.mesh.points, frame.positions, masses) > LIES
    if middle[2] < SUNK * watch.start[2] or leans:
        watch.fell = frame.time
    else:
        watch.last = middle
    return watch


def _judged(task: Task, watch: _Watch | None) -> Try:
    if watch is None:
        return Try(0.0, 0.0, 0.0)
    ahead, aside, _ = (watch.last - watch.start) / task.length
    # the last look at a fall is within the time
    lasted = 1.0 if watch.fell is None else min(0.999, watch.fell / task.seconds)
    return Try(float(ahead), abs(float(aside)), lasted)
