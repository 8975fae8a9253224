"""Walking: feet swung in turn while the body goes on over the others (docs/method.md section 4)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.for_any_body.righting import righting
from warp_softbody.controllers.motions.for_any_body.step_gains import StepGains
from warp_softbody.controllers.motions.for_any_body.stepping import Stepping
from warp_softbody.controllers.motions.for_any_body.ways import stepping, way_to_walk
from warp_softbody.controllers.motions.tracking import MissingRate, following
from warp_softbody.controllers.motions.trajectories import eased_change, smooth_step
from warp_softbody.controllers.motions.walking_feet import FeetNow, upward_only
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView

Gait = tuple[tuple[int, ...], ...]

FEET = ("foot_0", "foot_1", "foot_2", "foot_3")

ONE_BY_ONE: Gait = ((3,), (0,), (1,), (2,))
"""A fore foot, the hind foot across from it, then the other two: the creep of four-footed animals.
It begins with a fore foot: a hind foot that is lifted out of the first stance takes the fore foot
across from it along."""

DIAGONAL_PAIRS: Gait = ((0, 3), (1, 2))
"""A trot without flight."""


@dataclass(frozen=True, kw_only=True)
class WalkGains:
    """Gains, weights and timing of walking along x, in units of the body (`BodyUnits`).

    Attributes:
        stride: L, that the body goes on while every foot is swung once.
        swing: sqrt(L/g), from one lift-off to the next.
        lift: L, height of a swung foot's lowest node halfway.
        touch_down: share of the swing in which the plan counts on the ground below the foot again.
        sway: how far the centre of mass is moved away from the feet that are about to lift off, as
            a share of its distance from their middle.
        leash: L, how far the plan may run ahead of the body.
        position: Kp, g/L, of the centre of mass.
        velocity: Kd, sqrt(g/L), of the same.
        turn: g/L, how strongly the body is brought back to the orientation that it had at rest.
        spin: sqrt(g/L), decay of angular momentum.
        learning: sqrt(L/g), within which it is learnt what momentum a plan misses.
        momentum_weight: of the linear momentum, in units of m g dt.
        spin_weight: of the angular momentum, in units of m g L dt.
        foot_position: sqrt(g/L), how fast a foot comes back to its path.
        foot_velocity: sqrt(g/L), how fast its velocity comes near the one that is wanted.
        foot_weight: in units of g dt, of a swung foot's velocity, and along z of that of one that
            stands, so that it stays down.
        activation: cost of effort and change.
        ease: by how much more than one a change costs at lift-off, as a factor, so that the other
            feet take over the load in several steps.
        ease_time: share of the swing after which it costs as usual.
    """

    stride: float = field(default=0.34, metadata=dimension(length=1.0))
    swing: float = field(default=2.004, metadata=dimension(time=1.0))
    lift: float = field(default=0.045, metadata=dimension(length=1.0))
    touch_down: float = 0.25
    sway: float = 0.22
    leash: float = field(default=0.25, metadata=dimension(length=1.0))
    position: float = field(default=9.174, metadata=dimension(time=-2.0))
    velocity: float = field(default=3.831, metadata=dimension(time=-1.0))
    turn: float = field(default=0.0, metadata=dimension(time=-2.0))
    spin: float = field(default=1.916, metadata=dimension(time=-1.0))
    learning: float = field(default=0.6, metadata=dimension(time=1.0))
    momentum_weight: float = 0.005
    spin_weight: float = 0.06
    foot_position: float = field(default=3.193, metadata=dimension(time=-1.0))
    foot_velocity: float = field(default=9.578, metadata=dimension(time=-1.0))
    foot_weight: float = 0.001
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.08, change=0.09396)
    )
    ease: float = 9.0
    ease_time: float = 0.25

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(
            self,
            positive=("swing",),
            not_negative=(
                *("lift", "touch_down", "leash", "position", "velocity", "turn", "spin"),
                *("learning", "momentum_weight", "spin_weight", "foot_position", "foot_velocity"),
                *("foot_weight", "ease", "ease_time"),
            ),
            finite=("stride", "sway"),
        )
        checks.instance("WalkGains.activation", self.activation, ActivationCost)


@remembered
class Walk:
    """Walks along x, on level ground, for as long as it is asked."""

    required_regions = ("base",)
    """Regions that `for_` needs of a character, beside feet or quadrants of the base."""

    keeps_upright = True
    """A run in which the body falls is said to be doubtful."""

    def __init__(
        self,
        gains: WalkGains | None = None,
        *,
        gait: Gait,
        start: float = 0.9396,
        feet: tuple[str, ...] = FEET,
    ) -> None:
        """Lift the feet of each entry of ``gait`` in turn, from ``start`` sqrt(L/g) on."""
        self._gains = checks.optional("gains of Walk", gains, WalkGains)
        self._feet = feet = input_kinds.names("feet of Walk", feet)
        self._gait = _checked_gait(gait, len(feet))
        self._start = checks.number("start of Walk", start, low=0.0, unit="sqrt(L/g)")
        self._units: BodyUnits | None = None
        self._missing = MissingRate(self._gains.learning)
        self._origin = np.zeros(3)
        self._home: FloatArray | None = None
        # by the feet that are swung, once their home is known
        self._shifts: dict[tuple[int, ...], FloatArray] = {}
        self._left = np.zeros((len(feet), 3))
        self._phase = -1
        self._lands = True

    @property
    def interruptible(self) -> bool:
        """Whether all feet are to be on the ground."""
        return self._lands

    @classmethod
    def for_(
        cls,
        character: Character,
        *,
        heading: float = 0.0,
        speed: float | None = None,
        gains: StepGains | None = None,
    ) -> Stepping:
        """A walk of any body, step by step.

        Args:
            character: has a region `base` and three regions `foot_...` or more, of which those
                across from each other step together; else the quadrants `base_patch_0` to `_3` of
                its base, whose corners are lifted in turn.
            heading: rad, from x towards y.
            speed: m/s, of the plan on Earth; None for the one that the gains are made for.
            gains: None for those that suit what it walks on.

        Raises:
            InputError: the body lacks a region or muscles, or the speed is beyond its steps.
        """
        return stepping("Walk", character, way_to_walk(character), heading, speed, gains)

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._start *= self._units.time
            self._missing = MissingRate(self._gains.learning)
        g = self._gains
        feet = FeetNow(view, self._feet)
        home = self._stand(view, feet)
        phase, share = self._time(view.time)
        if phase != self._phase:
            self._phase, self._left = phase, feet.lowest
        swung = self._swung(phase)
        wanted = [*self._body(view, home)]
        for foot in range(len(self._feet)):
            swings = foot in swung
            path = self._path(home, foot, phase, share) if swings else self._hold(home, foot)
            own = self._foot(view, feet, foot, *path)
            wanted.append(own if swings else upward_only(own))
        landing = share > 1.0 - g.touch_down
        self._lands = landing or not swung
        down = [name for i, name in enumerate(self._feet) if landing or i not in swung]
        return Goals(
            objectives=tuple(wanted),
            patches=ground_patches(view, tuple(down)),
            activation=self._activation(phase, share),
        )

    def _stand(self, view: BodyView, feet: FeetNow) -> FloatArray:
        """Places of the feet relative to the centre of mass, as they were at first."""
        if self._home is None:
            self._origin = view.center_of_mass.copy()
            self._home = feet.lowest - self._origin
        return self._home

    def _time(self, time: float) -> tuple[int, float]:
        """Number of the swing, -1 before the first, and the share of it that is over."""
        since = time - self._start
        if since < 0.0:
            # of a walk that begins at once, the step before is all over
            return -1, time / self._start if self._start > 0.0 else 1.0
        phase = int(since / self._gains.swing)
        return phase, since / self._gains.swing - phase

    def _swung(self, phase: int) -> tuple[int, ...]:
        return self._gait[phase % len(self._gait)] if phase >= 0 else ()

    def _way(self, phase: int, share: float) -> tuple[float, float]:
        """How far along x the plan has come, m, and its speed, m/s; it starts within a cycle."""
        g, count = self._gains, len(self._gait)
        speed = g.stride / (count * g.swing)
        cycles = max(0.0, (phase + share) / count)
        if cycles < 1.0:
            return g.stride * cycles**2 / 2.0, speed * cycles
        return g.stride * (cycles - 0.5), speed

    def _body(self, view: BodyView, home: FloatArray) -> tuple[Objective, Objective]:
        """The centre of mass goes on and sways away from the feet that lift off; no turning."""
        g, dt = self._gains, view.time_step
        path = np.array([self._middle(home, view.time + ahead) for ahead in (-dt, 0.0, dt)])
        slack = self._slack(view, path[1])
        self._origin += slack
        wanted = following(view, path + slack, g.position, g.velocity)
        rate = self._missing.made_up(view, wanted)
        return (
            objectives.linear_momentum(view, rate, g.momentum_weight),
            objectives.angular_momentum(view, righting(view, g.turn, g.spin), g.spin_weight),
        )

    def _middle(self, home: FloatArray, time: float) -> FloatArray:
        """Where the centre of mass is wanted at a time, (3,) m."""
        phase, share = self._time(time)
        before, after = self._away(home, phase), self._away(home, phase + 1)
        middle = self._origin + before + smooth_step(share)[0] * (after - before)
        middle[0] += self._way(phase, share)[0]
        return np.asarray(middle)

    def _away(self, home: FloatArray, phase: int) -> FloatArray:
        """Where the centre of mass is wanted, from its usual place, when a swing begins."""
        swung = self._swung(phase)
        if swung not in self._shifts:
            shift = np.zeros(3)
            if swung:
                shift[:2] = -self._gains.sway * home[list(swung), :2].mean(axis=0)
            self._shifts[swung] = shift
        return self._shifts[swung]

    def _slack(self, view: BodyView, goal: FloatArray) -> FloatArray:
        """What takes the plan back to the body where that has slipped or was pushed away."""
        behind = view.center_of_mass - goal
        behind[2] = 0.0
        far = math.hypot(*behind.tolist())
        return np.asarray(behind * max(0.0, 1.0 - self._gains.leash / max(far, 1e-9)))

    def _path(
        self, home: FloatArray, foot: int, phase: int, share: float
    ) -> tuple[FloatArray, FloatArray]:
        """Place, m, and velocity, m/s, of a swung foot: mean x and y, z of its lowest node."""
        g, count = self._gains, len(self._gait)
        begin, end = self._left[foot], self._origin + home[foot]
        # It will stand while the body goes this way, so it is set down half of that ahead.
        end[0] += self._way(phase + 1, 0.0)[0] + 0.5 * g.stride * (count - 1) / count
        step, rate, _ = smooth_step(share)
        place, speed = begin + step * (end - begin), rate * (end - begin)
        up, climb, _ = smooth_step(min(2.0 * share, 2.0 - 2.0 * share))
        place[2] += g.lift * up
        speed[2] += g.lift * climb * (2.0 if share < 0.5 else -2.0)
        return place, speed / g.swing

    def _foot(
        self, view: BodyView, feet: FeetNow, foot: int, place: FloatArray, speed: FloatArray
    ) -> Objective:
        """A foot keeps to its path."""
        g, weights, now = self._gains, feet.weights[foot], feet.speeds[foot]
        way = speed + g.foot_position * (place - feet.lowest[foot])
        soon = now + view.time_step * g.foot_velocity * (way - now)
        unit = objectives.weight_of(view) / view.mass * view.time_step
        stays = ("foot", self._feet[foot])
        return objectives.velocity(view, weights, soon, g.foot_weight, unit=unit, stays=stays)

    def _hold(self, home: FloatArray, foot: int) -> tuple[FloatArray, FloatArray]:
        """Place, m, and velocity, m/s, of a foot that stands; only its height is asked for."""
        return self._origin + home[foot], np.zeros(3)

    def _activation(self, phase: int, share: float) -> ActivationCost:
        g = self._gains
        if phase < 0 or share >= g.ease_time:
            return g.activation
        return eased_change(g.activation, g.ease, share / g.ease_time)


def _checked_gait(gait: object, feet: int) -> Gait:
    """Which feet are swung together, one entry after the other."""
    wanted = f"a tuple of tuples of feet from 0 to {feet - 1}"
    entries = checks.several("gait of Walk", gait, wanted)
    if not entries:
        checks.refuse("gait of Walk", wanted, gait)
    swings = [checks.several("a swing in the gait of Walk", entry, wanted) for entry in entries]
    return tuple(
        tuple(checks.whole("a foot in the gait of Walk", foot, high=feet - 1) for foot in swing)
        for swing in swings
    )
