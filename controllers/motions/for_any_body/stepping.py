"""Going step by step: feet, or parts of a sole, are moved in turn while the others hold.

The plan is a frame that goes on with the body, in which every foot has a place; where feet have
slipped, the frame follows them. A foot in its turn is moved from where it stands to half of its
stride ahead of its place. Before it is lifted, the centre of mass is brought to the nearest point
over the area of the other feet (McGhee and Frank, On the stability properties of quadruped creeping
gaits, 1968), and it is set down further on by what the capture point drifts.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.contact_quadrature import measure
from warp_softbody.controllers.controller import Goals, seen
from warp_softbody.controllers.motions.for_any_body.righting import righting
from warp_softbody.controllers.motions.for_any_body.step_gains import StepGains
from warp_softbody.controllers.motions.for_any_body.support import drawn_together, hull, nearest_in
from warp_softbody.controllers.motions.guidance import Feet, Guidance
from warp_softbody.controllers.motions.moving_frame import MovingFrame, Rates
from warp_softbody.controllers.motions.steerable import Steerable
from warp_softbody.controllers.motions.steering import Guide
from warp_softbody.controllers.motions.tracking import following
from warp_softbody.controllers.motions.trajectories import smooth_step
from warp_softbody.controllers.motions.walk_course import TurnTaking
from warp_softbody.controllers.motions.walking_feet import upward_only
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import Patch, patches_of
from warp_softbody.world.view import BodyView

Nodes = npt.NDArray[np.int32]

DRIFT_TIME = 0.5
"""Of a step: time constant of what the capture point is thought to drift."""

LEAST_HEIGHT = 1e-3
"""L, of the centre of mass above the feet, with which the capture point is reckoned."""


class _Feet:
    """Feet in a step: nodal weights (f, n), and places (f, 3) m of mean x and y and lowest z."""

    def __init__(self, view: BodyView, nodes: tuple[Nodes, ...]) -> None:
        self.weights = np.zeros((len(nodes), view.node_count))
        for row, own in zip(self.weights, nodes, strict=True):
            row[own] = 1.0 / len(own)
        self.places = self.weights @ view.positions
        self.places[:, 2] = [view.positions[own, 2].min() for own in nodes]


class _Now(NamedTuple):
    """When a plan is asked: number of the step, -1 before the first, and shares that are over."""

    number: int
    share: float
    swing: float


class Stepping(Steerable):
    """Moves feet in turn along a heading; made by `Walk.for_` and `Crawl.for_`, for one run."""

    def __init__(
        self,
        gains: StepGains,
        *,
        feet: tuple[Nodes, ...],
        turns: tuple[tuple[int, ...], ...],
        heading: float = 0.0,
        start: float = 1.0,
        steering: Guide | None = None,
        most_stride: float = 0.0,
    ) -> None:
        """Move the feet of each entry of ``turns``, from ``start`` sqrt(L/g) on.

        ``feet`` are nodes of the skin, ``heading`` is in rad from x towards y, ``most_stride`` is
        what may be asked for, in L, where it is more than the stride of the gains.
        """
        self._gains = gains
        self._feet = feet
        self._turns = turns
        self._turn_of = [
            next(i for i, turn in enumerate(turns) if k in turn) for k in range(len(feet))
        ]
        self._heading = heading
        self._start = start
        self._guide = steering
        self._most_stride = most_stride
        self._units: BodyUnits | None = None
        self._guidance: Guidance | None = None
        self._taking = TurnTaking(turns)
        self._home = np.zeros((len(feet), 3))
        self._frame = MovingFrame(np.zeros(2))
        self._asked = self._hastening = Rates()
        self._height = 0.0
        self._moving: tuple[int, ...] = ()
        self._number = -1
        self._left = self._home
        self._shift = self._next = np.zeros(3)
        self._drift = np.zeros(2)
        self._swings = False

    @property
    def interruptible(self) -> bool:
        """Whether no foot is off the ground."""
        return not self._swings

    def _has_arrived(self) -> bool:
        return self._guidance is not None and self._guidance.arrived

    def _be_guided(self, guide: Guide) -> None:
        if self._guidance is not None:
            self._guidance.follow(guide)
        self._guide = guide

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        feet = _Feet(view, self._feet)
        if self._units is None:
            self._begin(view, feet)
        now = self._time(view.time)
        assert self._guidance is not None
        if now.number >= 0:
            self._asked = self._guidance.rates(view, self._frame)
        if now.number != self._number:
            self._enter(view, feet, now.number)
        moving = self._moving
        self._follow(view, feet, moving, now)
        swung = moving if now.swing >= 0.0 else ()
        self._swings = self._gains.lift > 0.0 and bool(swung)
        wanted = self._body(view, now)
        for foot in range(len(self._feet)):
            if foot in swung:
                wanted.append(self._swung(view, feet, foot, now))
            elif self._gains.lift > 0.0:
                place = self._stands(self._frame, foot)
                wanted.append(upward_only(self._foot(view, feet, foot, place, np.zeros(3))))
        return Goals(
            objectives=tuple(wanted),
            patches=self._patches(view, swung, now.swing),
            activation=self._gains.activation,
        )

    def _begin(self, view: BodyView, feet: _Feet) -> None:
        self._units = BodyUnits.of(view)
        self._gains = in_si(self._gains, self._units)
        self._start *= self._units.time
        self._height = float(view.center_of_mass[2])
        self._home = feet.places - view.center_of_mass
        self._left = feet.places
        g, length = self._gains, self._units.length
        own = Feet(
            length=length,
            reach=max(float(np.hypot(*self._home[:, :2].T).max()), LEAST_HEIGHT * length),
            cycle=len(self._turns) * g.step,
            stride=g.stride,
            most_stride=self._most_stride * length,
        )
        self._guidance = Guidance(self._guide, own, self._heading)
        self._hastening = own.hastening
        # a body that goes straight on is at its speed at once
        rates = Rates(own.usual) if self._guide is None else Rates()
        self._frame = MovingFrame(view.center_of_mass[:2].copy(), 0.0, rates)

    def _time(self, time: float) -> _Now:
        g = self._gains
        since = (time - self._start) / g.step
        if since < 0.0:
            return _Now(-1, 0.0, -1.0)
        number = math.floor(since)
        return _Now(number, since - number, (since - number - g.stand) / (1.0 - g.stand))

    def _enter(self, view: BodyView, feet: _Feet, number: int) -> None:
        """Note where feet are when a step begins, and where the centre of mass is to be in it."""
        self._number, self._left, self._shift = number, feet.places, self._next
        self._next = np.zeros(3)
        still = not any(self._asked) and not any(self._frame.rates)
        self._moving = self._taking.turn(number, standing=still) if number >= 0 else ()
        standing = [own for foot, own in enumerate(self._feet) if foot not in self._moving]
        if self._gains.lift > 0.0 and standing and self._moving:
            corners = hull(view.positions[np.concatenate(standing), :2])
            area = drawn_together(corners, self._gains.margin)
            self._next[:2] = nearest_in(area, self._frame.place) - self._frame.place

    def _placed(self, foot: int, now: _Now) -> MovingFrame:
        """The frame for which a foot that stands was set down."""
        count = len(self._turns)
        ago = (now.number - 1 - self._turn_of[foot]) % count
        steps = (count - 1) / 2.0 - ago - now.share
        return self._frame.on(steps * self._gains.step, self._heading)

    def _stands(self, frame: MovingFrame, foot: int) -> FloatArray:
        """Where (3,) m a foot is that stands in its place in a frame."""
        home = self._home[foot]
        return np.array([*frame.at(home[:2]), self._height + home[2]])

    def _velocity(self) -> FloatArray:
        """Of the frame, (3,) m/s."""
        return np.array([*self._frame.velocity(self._heading), 0.0])

    def _follow(self, view: BodyView, feet: _Feet, moving: tuple[int, ...], now: _Now) -> None:
        """Let the frame go on, and after the feet that stand."""
        g, dt, frame = self._gains, view.time_step, self._frame
        if now.number < 0:
            return
        stands = [foot for foot in range(len(self._feet)) if foot not in moving]
        stands = stands or list(range(len(self._feet)))
        wanted = [self._stands(self._placed(foot, now), foot) for foot in stands]
        slipped = (feet.places[stands] - np.array(wanted)).mean(axis=0)
        speed = (view.linear_momentum / view.mass - self._velocity())[:2]
        self._drift += min(1.0, dt / (DRIFT_TIME * g.step)) * (speed - self._drift)
        soon = frame.steered(dt, self._asked, self._hastening, self._heading)
        far = float(np.hypot(*slipped[:2]))
        # within the leash the body is only late, and what is late is pushed the harder
        beyond = max(0.0, 1.0 - g.leash / far) if far > 0.0 else 0.0
        self._frame = soon._replace(place=soon.place + dt * g.settle * beyond * slipped[:2])

    def _body(self, view: BodyView, now: _Now) -> list[Objective]:
        """The centre of mass goes on and sways to where the other feet bear it; no turning."""
        g, dt = self._gains, view.horizon
        step, rate, _ = smooth_step(now.share / g.stand if g.stand > 0.0 else 1.0)
        sway = self._next - self._shift
        goal = np.array([*self._frame.place, self._height]) + self._shift + step * sway
        speed = self._velocity() if now.number >= 0 else np.zeros(3)
        if g.stand > 0.0:
            speed = speed + rate / (g.stand * g.step) * sway
        path = goal + dt * np.outer([-1.0, 0.0, 1.0], speed)
        linear = following(view, path, g.position, g.velocity)
        return [
            objectives.linear_momentum(view, linear, g.momentum_weight),
            objectives.angular_momentum(view, self._righting(view), g.spin_weight),
        ]

    def _righting(self, view: BodyView) -> FloatArray:
        g, frame = self._gains, self._frame
        return righting(view, g.turn, g.spin, yaw=frame.yaw, turning=frame.rates.turning)

    def _swung(self, view: BodyView, feet: _Feet, foot: int, now: _Now) -> Objective:
        """A foot goes from where it was left to half a stride ahead of its place."""
        g = self._gains
        lasts = g.step * (1.0 - g.stand)
        begin = self._left[foot]
        # it is in its place when half of the time is over that it stands
        steps = (1.0 - now.share) + 0.5 * (len(self._turns) - 1)
        end = self._stands(self._frame.on(steps * g.step, self._heading), foot)
        end[:2] += self._caught(view)
        step, rate, _ = smooth_step(now.swing)
        place, speed = begin + step * (end - begin), rate * (end - begin) / lasts
        up, climb, _ = smooth_step(min(2.0 * now.swing, 2.0 - 2.0 * now.swing))
        place[2] = self._home[foot, 2] + self._height + g.lift * up
        speed[2] = g.lift * climb * (2.0 if now.swing < 0.5 else -2.0) / lasts
        return self._foot(view, feet, foot, place, speed)

    def _caught(self, view: BodyView) -> FloatArray:
        """By how much (2,) m a foot is set down further on, so that the body does not fall."""
        assert self._units is not None
        height = float(view.center_of_mass[2] - self._left[:, 2].min())
        height = max(height, LEAST_HEIGHT * self._units.length)
        falls_in = math.sqrt(height * view.mass / objectives.weight_of(view))
        return np.asarray(self._gains.capture * falls_in * self._drift)

    def _foot(
        self, view: BodyView, feet: _Feet, foot: int, place: FloatArray, speed: FloatArray
    ) -> Objective:
        """A foot keeps to its path: a place, m, and a speed, m/s."""
        g, weights = self._gains, feet.weights[foot]
        now = weights @ view.velocities
        way = speed + g.foot_position * (place - feet.places[foot])
        soon = now + view.horizon * g.foot_velocity * (way - now)
        unit = objectives.weight_of(view) / view.mass * view.horizon
        return objectives.velocity(view, weights, soon, g.foot_weight, unit=unit)

    def _patches(self, view: BodyView, swung: tuple[int, ...], swing: float) -> tuple[Patch, ...]:
        """The feet that bear; parts that are pushed along bear too, but do not hold."""
        g, ground = self._gains, view.scene.ground
        if ground is None:
            return ()
        landing = g.lift == 0.0 or swing > 1.0 - g.touch_down
        bear = [foot for foot in range(len(self._feet)) if landing or foot not in swung]
        made = patches_of(view, ground, measure(view, ground, [self._feet[foot] for foot in bear]))
        if g.lift > 0.0:
            return made
        pushed = (foot in swung for foot in bear)
        return tuple(
            replace(patch, slips=True) if slips else patch
            for patch, slips in zip(made, pushed, strict=True)
        )
