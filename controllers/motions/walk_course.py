"""The course of a walk: a frame that goes as it is steered, and the feet that swing meanwhile."""

from __future__ import annotations

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.guidance import Feet, Guidance
from warp_softbody.controllers.motions.moving_frame import MovingFrame, Rates
from warp_softbody.controllers.motions.steering import Guide
from warp_softbody.world.view import BodyView

Turns = tuple[tuple[int, ...], ...]


class TurnTaking:
    """Which feet are moved in a step; a body that stands moves each once more, then none."""

    def __init__(self, turns: Turns) -> None:
        """``turns`` are the feet that are moved together, one entry after the other."""
        self._turns = turns
        self._stood = 0

    def turn(self, number: int, *, standing: bool) -> tuple[int, ...]:
        """The feet of a step, to be asked once for each; whether the body is told to stand."""
        self._stood = self._stood + 1 if standing else 0
        return self._turns[number % len(self._turns)] if self._stood <= len(self._turns) else ()


class Course:
    """Where the frame is, how it goes on, and which feet are swung; for one run.

    Attributes:
        before: the frame one horizon before (`BodyView.horizon`).
        now: at the step's start.
        ahead: one horizon after it.
        swung: feet of the present swing.
        next: feet of the swing after it.
    """

    def __init__(
        self,
        feet: Feet,
        turns: Turns,
        place: FloatArray,
        *,
        guide: Guide | None,
        heading: float,
    ) -> None:
        """Stand at a place (2,) m."""
        self._feet, self._heading = feet, heading
        self._stands = 0.5 * feet.cycle * (len(turns) - 1) / len(turns)
        self._guidance = Guidance(guide, feet, heading)
        self._taking = TurnTaking(turns)
        self._wanted = Rates()
        self._phase = -1
        self.before = self.now = self.ahead = self._soon = MovingFrame(place)
        # the frames since one horizon before
        self._past: tuple[MovingFrame, ...] = ()
        self.swung: tuple[int, ...] = ()
        self.next = turns[0]

    @property
    def arrived(self) -> bool:
        """Whether a trail was followed to its end."""
        return self._guidance.arrived

    def steer(self, guide: Guide) -> None:
        """Be guided by something else from now on."""
        self._guidance.follow(guide)

    def go_on(self, view: BodyView, phase: int) -> None:
        """Take the frame to the step from ``view`` on, in a swing, which is -1 before the first."""
        count = view.steps_ahead
        self._past = (*(self._past or (self.now,) * count), self.now)[-count:]
        self.before, self.now = self._past[0], self._soon
        if phase < 0:
            return
        self._wanted = self._guidance.rates(view, self.now)
        if phase != self._phase:
            standing = not any(self._wanted) and not any(self.now.rates)
            self.swung, self._phase = self.next, phase
            self.next = self._taking.turn(phase + 1, standing=standing)
        self.ahead = self._soon = self._later(self.now, view.time_step)
        if count > 1:
            self.ahead = self._later(self.now, view.horizon)

    def shift(self, way: FloatArray) -> None:
        """Move the frame by a way (2,) m, where the body has slipped or was pushed."""

        def moved(frame: MovingFrame) -> MovingFrame:
            return frame._replace(place=frame.place + way)

        self.before, self.now, self.ahead = map(moved, (self.before, self.now, self.ahead))
        self._past, self._soon = tuple(map(moved, self._past)), moved(self._soon)

    def when_down(self, swings: float) -> MovingFrame:
        """The frame for which a foot is set down that is in the air for some seconds yet.

        It is that when half of the time is over that the foot then stands, if the body goes as it
        is steered by then.
        """
        down = self._later(self.now, swings)
        return down._replace(rates=self._wanted).on(self._stands, self._heading)

    def _later(self, frame: MovingFrame, seconds: float) -> MovingFrame:
        return frame.steered(seconds, self._wanted, self._feet.hastening, self._heading)
