"""Walking: feet swung in turn while the body goes on over the others (docs/method.md section 4)."""

from __future__ import annotations

import math

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.body_measures import angle_turned
from warp_softbody.controllers.motions.footing import FootingOnTerrain, Stance
from warp_softbody.controllers.motions.for_any_body.righting import righting
from warp_softbody.controllers.motions.for_any_body.step_gains import StepGains
from warp_softbody.controllers.motions.for_any_body.stepping import Stepping
from warp_softbody.controllers.motions.for_any_body.ways import stepping, way_to_walk
from warp_softbody.controllers.motions.guidance import Feet
from warp_softbody.controllers.motions.moving_frame import MovingFrame, turned
from warp_softbody.controllers.motions.steerable import Steerable
from warp_softbody.controllers.motions.steering import Guide, checked_guide
from warp_softbody.controllers.motions.stepping_over import stepping_over
from warp_softbody.controllers.motions.tracking import MissingRate, following
from warp_softbody.controllers.motions.trajectories import eased_change, smooth_step
from warp_softbody.controllers.motions.walk_course import Course
from warp_softbody.controllers.motions.walk_gains import WalkGains
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

MOST_STRIDE = 0.6
"""L, as far as a foot of letter X is swung; with longer strides the middle comes to the ground."""


EDGE = 0.5
"""Lifts, by which ground that stands above the straight way is an edge to be stepped over."""


@remembered
class Walk(Steerable):
    """Walks where it is steered, straight on where it is not, up and down what the ground does."""

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
        heading: float = 0.0,
        steering: Guide | None = None,
    ) -> None:
        """Lift the feet of each entry of ``gait`` in turn, from ``start`` sqrt(L/g) on.

        Args:
            gains: None for the usual ones.
            gait: numbers of the feet that are swung together, one swing after the other.
            start: sqrt(L/g), when the first swing begins.
            feet: names of the regions that are the feet.
            heading: rad, from x towards y, of what is forward as the body stands at first.
            steering: how fast to go which way: a `Steering`, several with their times, a `Trail`,
                or a function of the view that gives a `Steering`; None for straight on at the speed
                for which the gains are made.
        """
        self._gains = checks.optional("gains of Walk", gains, WalkGains)
        self._feet = feet = input_kinds.names("feet of Walk", feet)
        self._gait = _checked_gait(gait, len(feet))
        self._start = checks.number("start of Walk", start, low=0.0, unit="sqrt(L/g)")
        self._heading = checks.number("heading of Walk", heading, unit="rad")
        self._guide = None if steering is None else checked_guide("steering of Walk", steering)
        self._missing = MissingRate(self._gains.learning)
        self._course: Course | None = None
        self._home = self._left = np.zeros((len(feet), 3))
        self._sways: dict[tuple[int, ...], FloatArray] = {}
        self._beside: dict[int, FloatArray] = {}
        self._height = 0.0
        self._terrain: FootingOnTerrain | None = None
        self._yaw = 0.0
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
        steering: Guide | None = None,
    ) -> Stepping:
        """A walk of any body, step by step.

        Args:
            character: has a region `base` and three regions `foot_...` or more, of which those
                across from each other step together; else the quadrants `base_patch_0` to `_3` of
                its base, whose corners are lifted in turn.
            heading: rad, from x towards y.
            speed: m/s, of the plan on Earth; None for the one that the gains are made for.
            gains: None for those that suit what it walks on.
            steering: as that of `Walk`, in place of a speed; "forward" is along the heading.

        Raises:
            InputError: the body lacks a region or muscles, or the speed is beyond its steps.
        """
        return stepping("Walk", character, way_to_walk(character), heading, speed, gains, steering)

    def _has_arrived(self) -> bool:
        return self._course is not None and self._course.arrived

    def _be_guided(self, guide: Guide) -> None:
        if self._course is not None:
            self._course.steer(guide)
        self._guide = guide

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        feet = FeetNow(view, self._feet)
        if self._course is None:
            self._course = self._begun(view, feet)
        phase, share = self._time(view.time)
        self._course.go_on(view, phase)
        if phase != self._phase:
            self._phase, self._left = phase, feet.lowest
            self._leave_edges(self._course)
        swung = self._course.swung
        wanted = [*self._body(view, self._course)]
        for foot in range(len(self._feet)):
            swings = foot in swung
            path = self._path(self._course, feet, foot, share) if swings else self._hold(feet, foot)
            own = self._foot(view, feet, foot, *path)
            wanted.append(own if swings else upward_only(own))
        landing = share > 1.0 - self._gains.touch_down
        self._lands = landing or not swung
        down = [name for i, name in enumerate(self._feet) if landing or i not in swung]
        return Goals(
            objectives=tuple(wanted),
            patches=ground_patches(view, tuple(down)),
            activation=self._activation(swung, share),
        )

    def _begun(self, view: BodyView, feet: FeetNow) -> Course:
        """Take over the units of the body, and the places of the feet as they are at first."""
        units = BodyUnits.of(view)
        self._gains = g = in_si(self._gains, units)
        self._start *= units.time
        self._missing = MissingRate(g.learning)
        self._home, self._sways = feet.lowest - view.center_of_mass, {}
        self._height = float(view.center_of_mass[2])
        self._terrain = FootingOnTerrain.of(view, feet.lowest, self._feet)
        self._yaw = angle_turned(view, 0, 1)
        own = Feet(
            length=units.length,
            reach=float(np.hypot(*self._home[:, :2].T).max()),
            cycle=g.swing * len(self._gait),
            stride=g.stride,
            most_stride=MOST_STRIDE * units.length,
        )
        place = view.center_of_mass[:2].copy()
        return Course(own, self._gait, place, guide=self._guide, heading=self._heading)

    def _time(self, time: float) -> tuple[int, float]:
        """Number of the swing, -1 before the first, and the share of it that is over."""
        since = time - self._start
        if since < 0.0:
            # of a walk that begins at once, the step before is all over
            return -1, time / self._start if self._start > 0.0 else 1.0
        phase = int(since / self._gains.swing)
        return phase, since / self._gains.swing - phase

    def _body(self, view: BodyView, course: Course) -> tuple[Objective, Objective]:
        """The centre of mass goes on and sways away from the feet that lift off."""
        g, dt = self._gains, view.horizon
        frames = zip((-dt, 0.0, dt), (course.before, course.now, course.ahead), strict=True)
        path = np.array([self._middle(course, frame, view.time + ahead) for ahead, frame in frames])
        slack = self._slack(view, path[1])
        course.shift(slack[:2])
        wanted = following(view, path + slack, g.position, g.velocity)
        rate = self._missing.made_up(view, wanted)
        return (
            objectives.linear_momentum(view, rate, g.momentum_weight),
            objectives.angular_momentum(view, self._righting(view, course), g.spin_weight),
        )

    def _righting(self, view: BodyView, course: Course) -> FloatArray:
        """Rate of angular momentum (3,) N m by which the body comes upright and faces its way."""
        g, frame = self._gains, course.now
        yaw, turning = self._yaw + frame.yaw, frame.rates.turning
        return righting(view, g.turn, g.spin, yaw=yaw, turning=turning)

    def _middle(self, course: Course, frame: MovingFrame, time: float) -> FloatArray:
        """Where the centre of mass is wanted at a time, (3,) m."""
        phase, share = self._time(time)
        # one step ahead the next swing may have begun
        begun = phase > self._phase
        before, after = (course.next, course.next) if begun else (course.swung, course.next)
        if phase < self._phase:
            before = after = course.swung
        away, soon = self._away(before), self._away(after)
        place = frame.at(away + smooth_step(share)[0] * (soon - away))
        # without the sway, which goes to and fro
        height = self._height if self._terrain is None else self._stance(frame).height
        return np.array([*place, height])

    def _stance(self, frame: MovingFrame) -> Stance:
        """How the body stands on ground that is not level, in the middle of a frame."""
        assert self._terrain is not None
        forward = np.array([math.cos(self._heading), math.sin(self._heading)])
        middle, ahead = frame.at(np.zeros(2)), frame.at(self._gains.stride * forward)
        home = self._home.copy()
        home[:, :2] = [frame.at(place) - middle for place in self._home[:, :2]]
        return self._terrain.stance(middle, home, ahead - middle)

    def _foothold(self, frame: MovingFrame, foot: int) -> FloatArray:
        """Where a foot (2,) m belongs on ground that is not level, in a frame."""
        return np.asarray(frame.at(np.zeros(2)) + self._stance(frame).home[foot, :2])

    def _leave_edges(self, course: Course) -> None:
        """Choose where feet that swing now are to land beside an edge that is at their place."""
        self._beside = {}
        if self._terrain is None:
            return
        frame = course.when_down(self._gains.swing)
        forward = turned(np.array([math.cos(self._heading), math.sin(self._heading)]), frame.yaw)
        for foot in course.swung:
            place = np.array([*self._foothold(frame, foot), self._left[foot, 2]])
            shift = self._terrain.beside_edge(place, forward)
            if shift.any():
                self._beside[foot] = place[:2] + shift

    def _away(self, swung: tuple[int, ...]) -> FloatArray:
        """Where in the frame (2,) m the centre of mass is wanted when some feet begin to swing."""
        known = self._sways.get(swung)
        if known is None:
            known = np.zeros(2)
            if swung:
                known = np.asarray(-self._gains.sway * self._home[list(swung), :2].mean(axis=0))
            self._sways[swung] = known
        return known

    def _slack(self, view: BodyView, goal: FloatArray) -> FloatArray:
        """What takes the plan back to the body where that has slipped or was pushed away."""
        behind = view.center_of_mass - goal
        behind[2] = 0.0
        far = math.hypot(*behind.tolist())
        return np.asarray(behind * max(0.0, 1.0 - self._gains.leash / max(far, 1e-9)))

    def _path(
        self, course: Course, feet: FeetNow, foot: int, share: float
    ) -> tuple[FloatArray, FloatArray]:
        """Place, m, and velocity, m/s, of a swung foot: mean x and y, z of its lowest node."""
        g, begin, end = self._gains, self._left[foot], self._hold(feet, foot)[0]
        frame, lift = course.when_down((1.0 - share) * g.swing), g.lift
        end[:2] = frame.at(self._home[foot, :2])
        if self._terrain is not None:
            end[:2] = self._beside.get(foot, self._foothold(frame, foot))
            end[2] = self._terrain.foothold(foot, end)
            hump = self._terrain.hump(begin, end)
            if hump > EDGE * lift:
                peak = self._terrain.highest(foot, begin, end) + lift
                place, speed = stepping_over(begin, end, peak, share)
                return place, speed / g.swing
            lift += hump
        step, rate, _ = smooth_step(share)
        place, speed = begin + step * (end - begin), rate * (end - begin)
        up, climb, _ = smooth_step(min(2.0 * share, 2.0 - 2.0 * share))
        place[2] += lift * up
        speed[2] += lift * climb * (2.0 if share < 0.5 else -2.0)
        return place, speed / g.swing

    def _foot(
        self, view: BodyView, feet: FeetNow, foot: int, place: FloatArray, speed: FloatArray
    ) -> Objective:
        """A foot keeps to its path."""
        g, weights, now = self._gains, feet.weights[foot], feet.speeds[foot]
        way = speed + g.foot_position * (place - feet.lowest[foot])
        soon = now + view.horizon * g.foot_velocity * (way - now)
        unit = objectives.weight_of(view) / view.mass * view.horizon
        stays = ("foot", self._feet[foot])
        return objectives.velocity(view, weights, soon, g.foot_weight, unit=unit, stays=stays)

    def _hold(self, feet: FeetNow, foot: int) -> tuple[FloatArray, FloatArray]:
        """Place, m, and velocity, m/s, of a foot that stands; only its height is asked for."""
        height = self._height + self._home[foot, 2]
        if self._terrain is not None:
            height = self._terrain.foothold(foot, feet.lowest[foot])
        return np.array([0.0, 0.0, height]), np.zeros(3)

    def _activation(self, swung: tuple[int, ...], share: float) -> ActivationCost:
        g = self._gains
        if not swung or share >= g.ease_time:
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
