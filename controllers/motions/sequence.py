"""Motions one after the other: each begins from the body as the one before left it."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.controller import Controller, Goals, seen
from warp_softbody.controllers.inner_controllers import says, two_with_one
from warp_softbody.controllers.motions.combined import Combined, told
from warp_softbody.controllers.motions.composition import faded
from warp_softbody.controllers.motions.motion import Motion
from warp_softbody.controllers.motions.motion_span import MotionSpan, with_inner_spans
from warp_softbody.controllers.motions.standing_view import (
    Workroom,
    from_its_start,
    standing_view,
)
from warp_softbody.controllers.motions.trajectories import smooth_step
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView

PATIENCE = 5.0
"""sqrt(L/g), for which a motion that is over is let go on until it can be interrupted."""


class _Running(NamedTuple):
    """A motion under way: its controller, when (s) and where (m) it began, and its workroom."""

    motion: Motion
    controller: Any
    begun: float
    start: FloatArray
    workroom: Workroom

    def view(self, view: BodyView) -> BodyView:
        return from_its_start(view, self.begun, self.workroom)

    def goals(self, view: BodyView) -> Goals | None:
        goals: Goals | None = self.controller.goals(self.view(view))
        return goals


@remembered
class Sequence:
    """One motion after the other, composed of any controllers.

    Each sees a time that begins with it, and takes the heights and places to which it keeps from
    the body at rest where it then is. Over a time the objectives of the motion before fade into
    its own, and a change of the muscles costs more, so that the pose goes over smoothly. A motion
    that is over goes on until it can be interrupted: until a foot is down, or the body has landed
    (an attribute ``interruptible`` of its controller, where it has one). Headings stay those of
    the world.
    """

    def __init__(
        self,
        motions: Iterable[Motion | Controller],
        *,
        rounds: int = 1,
        fade: float = 0.5,
        ease: float = 4.0,
    ) -> None:
        """Take motions in turn.

        Args:
            motions: of which all but the last end; a controller stands for a `Motion` of it.
            rounds: how often all are taken, each time by copies of their controllers.
            fade: sqrt(L/g), over which one goes over into the next.
            ease: by how much more than one a change of the muscles costs at its beginning.

        Raises:
            InputError: there are none, or one that is followed by another never ends.
        """
        given = checks.several("motions of Sequence", motions, "motions")
        self._motions = tuple(_as_motion(number, own) for number, own in enumerate(given))
        self._rounds = checks.whole("rounds of Sequence", rounds, low=1)
        self._fade = checks.number("fade of Sequence", fade, low=0.0, unit="sqrt(L/g)")
        self._ease = checks.number("ease of Sequence", ease, low=0.0)
        if not self._motions:
            raise InputError("motions of Sequence must hold a motion at least")
        _refuse_endless(self._motions if self._rounds > 1 else self._motions[:-1])
        # those of a controller that stands there twice would go on where they were
        given_twice = two_with_one([own.controller] for own in self._motions)
        self._copied = self._rounds > 1 or given_twice is not None
        self._number = -1
        self._now: _Running | None = None
        self._before: _Running | None = None
        # of the motions before the present one
        self._spans: list[MotionSpan] = []
        self._over: float | None = None

    @property
    def keeps_upright(self) -> bool:
        """Whether the last motion does, and the one that is on, which may turn the body over."""
        last = says(self._motions[-1].controller, "keeps_upright")
        return last and (self._now is None or says(self._now.controller, "keeps_upright"))

    @property
    def course(self) -> tuple[MotionSpan, ...]:
        """The motions that have begun, in the times of the views that the sequence was shown."""
        now = self._now
        if now is None:
            return ()
        span = MotionSpan(name=now.motion.title, begun=now.begun)
        return (*self._spans, *with_inner_spans(span, now.controller))

    @property
    def controllers(self) -> tuple[Controller, ...]:
        """Those of the motions, and the one that is on, where it is a copy of one of them."""
        now = () if self._now is None or not self._copied else (self._now.controller,)
        return (*(own.controller for own in self._motions), *now)

    @property
    def motions(self) -> tuple[Motion, ...]:
        """Of one round."""
        return self._motions

    @property
    def finished(self) -> bool:
        """Whether the last motion is over."""
        return self._number + 1 >= self._count and self._over is not None

    @property
    def interruptible(self) -> bool:
        """Whether the present motion is."""
        return self._now is None or says(self._now.controller, "interruptible", otherwise=True)

    @property
    def _count(self) -> int:
        return self._rounds * len(self._motions)

    def begin(self, view: BodyView, standing: BodyView) -> None:
        """Begin its first motion from a body that another one has moved."""
        self._enter(seen(view), told)

    def goals(self, view: BodyView) -> Goals | None:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._now is None:
            self._enter(view, _told_first)
        elif self._is_over(view, self._now):
            if self._number + 1 < self._count:
                self._enter(view, told)
        now = self._now
        assert now is not None
        share = self._share(view, now)
        if share >= 1.0:
            self._before = None
        before = None if self._before is None else self._before.goals(view)
        goals = faded(before, now.goals(view), smooth_step(share)[0])
        if goals is None or share >= 1.0:
            return goals
        dearer = goals.activation.change * (1.0 + self._ease * (1.0 - share) ** 2)
        return unchecked_copy(goals, activation=unchecked_copy(goals.activation, change=dearer))

    def _share(self, view: BodyView, now: _Running) -> float:
        """Of the time in which the last motion fades; nothing fades into the first one."""
        lasts = self._fade * BodyUnits.of(view).time
        if self._number == 0 or lasts == 0.0:
            return 1.0
        return (view.time - now.begun) / lasts

    def _is_over(self, view: BodyView, now: _Running) -> bool:
        """Whether the motion is over, and can be interrupted or has been waited for enough."""
        if self._over is None and now.motion.is_over(now.view(view), now.start, now.controller):
            self._over = view.time
        if self._over is None:
            return False
        patience = PATIENCE * BodyUnits.of(view).time
        return view.time - self._over > patience or says(
            now.controller, "interruptible", otherwise=True
        )

    def _enter(self, view: BodyView, tell: Callable[[Any, BodyView, BodyView], None]) -> None:
        """Begin the next motion, and tell its controller so."""
        before = self._now
        if before is not None:
            span = MotionSpan(name=before.motion.title, begun=before.begun, ended=view.time)
            self._spans += with_inner_spans(span, before.controller)
        self._number += 1
        self._over, self._before = None, before
        motion = self._motions[self._number % len(self._motions)]
        controller = copy.deepcopy(motion.controller) if self._copied else motion.controller
        self._now = _Running(motion, controller, view.time, view.center_of_mass.copy(), Workroom())
        own = self._now.view(view)
        tell(controller, own, standing_view(own))


def _told_first(controller: Any, view: BodyView, standing: BodyView) -> None:
    """As `told`, for the first motion of a run: what has no ``begin`` is asked of no step before.

    It remembers the heights and places of the body as the run begins.
    """
    if isinstance(controller, Combined):
        for own in controller.controllers:
            _told_first(own, view, standing)
    elif hasattr(controller, "begin") and not isinstance(controller, Sequence):
        # a sequence tells its own first motion
        controller.begin(view, standing)


def _as_motion(number: int, given: object) -> Motion:
    if isinstance(given, Motion):
        return given
    return Motion(controller=input_kinds.controller(f"motions[{number}] of Sequence", given))


def _refuse_endless(motions: Iterable[Motion]) -> None:
    for number, motion in enumerate(motions):
        if not motion.ends:
            raise InputError(
                f"motions[{number}] of Sequence ({motion.title}) never ends, but another one "
                "follows: give it seconds, distance or until"
            )
