"""Rolling by given angles: lean ahead of the contact, back to stop (docs/method.md section 4)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.any_body import require_muscles, require_regions
from warp_softbody.controllers.motions.axle import Axle
from warp_softbody.controllers.motions.body_measures import angle_turned, contact_point
from warp_softbody.controllers.motions.mean_shape import MeanShape
from warp_softbody.controllers.motions.roll_gains import ANY_BODY, Leg, RollGains
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patch_clusters import clustered_patches
from warp_softbody.controllers.patches import Patch
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView

LET_GO = 5.0
"""Time constants of the letting go after which muscles are slack for good: less than a hundredth
of the contraction is left."""

THERE = 0.1
"""rad from the end of a leg within which the body has arrived."""

STILL = 0.02
"""sqrt(g/L), of rolling, below which it counts as still."""


class _Wheel(NamedTuple):
    """A body as a wheel along x: height over its contact, inertia about that, and speed in SI."""

    height: float
    inertia: float
    speed: float

    @classmethod
    def of(cls, view: BodyView, rim: str, spin_inertia: float) -> _Wheel:
        """Of a body with an inertia about its centre of mass, on a region of its surface."""
        height = float((view.center_of_mass - contact_point(view, rim))[2])
        inertia = spin_inertia + view.mass * height**2
        momentum = view.angular_momentum[1] + height * view.linear_momentum[0]
        return cls(height, inertia, float(momentum) / inertia)


@remembered
class Roll:
    """Rolls leg by leg; afterwards passive.

    The speed that is wanted depends on the angle that is left, not on the time: so a body that is
    late still stops at the end of its leg. Its rate of change is asked of the momentum about the
    contact, and of the body's tilt, with which it leans ahead of it.
    """

    required_regions = ("rim",)
    """Regions that `for_` needs of a character."""

    def __init__(
        self,
        gains: RollGains | None = None,
        *,
        legs: tuple[Leg, ...],
        rim: str,
        patches: int = 6,
        parts: int = 64,
    ) -> None:
        """Roll on the nodes of a region ``rim``, divided into ``parts``, on so many patches."""
        self._gains = checks.optional("gains of Roll", gains, RollGains)
        self._legs = list(checks.items("legs of Roll", legs, Leg))
        self._rim = input_kinds.name("rim of Roll", rim)
        self._count = checks.whole("patches of Roll", patches, low=4, high=8)
        self._parts = checks.whole("parts of Roll", parts, low=self._count, high=2**16)
        self._last: tuple[Patch, ...] = ()
        self._units: BodyUnits | None = None
        self._angle = 0.0
        self._end = self._legs[0].direction * self._legs[0].turn if self._legs else 0.0
        self._begun = 0.0
        self._moved = 0.0
        self._reference = 0.0
        self._released = None if self._legs else 0.0

    @classmethod
    def for_(
        cls,
        character: Character,
        *,
        turn: float = 2.0 * math.pi,
        direction: float = 1.0,
        gains: RollGains | None = None,
    ) -> Roll:
        """A roll of any body that is round about y, along x.

        Args:
            character: has a region `rim`, on which it rolls.
            turn: rad.
            direction: 1 along x, -1 against it.
            gains: None for those of any body.

        Raises:
            InputError: the body has no rim or no muscles.
        """
        require_muscles("Roll", character)
        require_regions("Roll", character, cls.required_regions)
        leg = Leg(direction=direction, turn=turn)
        return cls(ANY_BODY if gains is None else gains, legs=(leg,), rim="rim")

    @property
    def finished(self) -> bool:
        """Whether it has come to the end of its last leg."""
        return self._released is not None

    def begin(self, view: BodyView, standing: BodyView) -> None:
        """Count the angle of the first leg from that by which the body has turned."""
        self._angle = angle_turned(view, 2, 0)
        self._end += self._angle

    def goals(self, view: BodyView) -> Goals | None:
        """Objectives of the step from ``view`` on; None once the muscles have let go."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._legs = [in_si(leg, self._units) for leg in self._legs]
        self._angle += float(np.angle(np.exp(1j * (angle_turned(view, 2, 0) - self._angle))))
        if self._released is not None:
            return self._let_go(view, self._units, view.time - self._released)
        shape = MeanShape.of(view)
        wheel = _Wheel.of(view, self._rim, shape.inertia)
        self._advance(view, self._units, wheel.speed)
        rate = self._acceleration(view, wheel.speed)
        weight = objectives.weight_of(view)
        return Goals(
            objectives=(
                self._rolling(view, wheel, rate),
                *self._steadiness(view, wheel.speed),
                self._shape(view, shape, rate * wheel.inertia / (weight * wheel.height)),
            ),
            patches=self._patches(view),
            activation=self._gains.activation,
        )

    def _advance(self, view: BodyView, units: BodyUnits, speed: float) -> None:
        """Take the next leg where the body has been still at the end of one, or let go."""
        if abs(self._end - self._angle) > THERE or abs(speed) > STILL / units.time:
            self._moved = view.time
        leg = self._legs[0]
        arrived = view.time - self._moved >= self._gains.hold
        if not (arrived or view.time - self._begun >= leg.longest):
            return
        if len(self._legs) == 1:
            self._released = view.time
            return
        del self._legs[0]
        self._begun = self._moved = view.time
        self._end = self._angle + self._legs[0].direction * self._legs[0].turn
        self._reference = 0.0

    def _acceleration(self, view: BodyView, speed: float) -> float:
        """Wanted rate of the speed of rolling, rad/s^2: that of the profile and what is off it."""
        g = self._gains
        before = self._reference
        wanted = self._profile(self._end - self._angle)
        most = abs(before) + g.speedup * view.time_step
        self._reference = float(np.clip(wanted, -most, most))
        ahead = float(
            np.clip((self._reference - before) / view.time_step, -g.acceleration, g.acceleration)
        )
        return float(
            np.clip(ahead + g.follow * (self._reference - speed), -g.acceleration, g.acceleration)
        )

    def _profile(self, left: float) -> float:
        """Speed, rad/s, with which the rest of the way, rad, is covered.

        Braking evenly it falls with the root of the way, and at last in proportion to it.
        """
        g = self._gains
        last = g.brake / g.closing
        speed = float(np.sqrt(2.0 * g.brake * abs(left) + last**2)) - last
        return float(np.sign(left)) * min(g.cruise, speed)

    def _rolling(self, view: BodyView, wheel: _Wheel, rate: float) -> Objective:
        """The momentum about the contact of a wheel whose speed changes at a rate, rad/s^2.

        Gravity changes it, by the weight's lever arm, and no muscle does: leaning is all there is.
        Of both momenta apart a plan pays for the one with the other, and so shakes.
        """
        unit = BodyUnits.of(view).length * objectives.weight_of(view) * view.horizon
        rows = objectives.angular_momentum_rows(view)[1:2]
        rows = rows + wheel.height * objectives.momentum_rows(view)[:1]
        target = wheel.inertia * (wheel.speed + view.horizon * rate)
        return Objective(
            name="rolling",
            rows=rows / unit,
            target=np.array([target / unit]),
            weight=np.array([self._gains.roll_weight]),
        )

    def _steadiness(self, view: BodyView, speed: float) -> tuple[Objective, ...]:
        """Decay of the momenta across the way and upward, and of the turning about these axes.

        A body that is steered is not asked to stop turning: so it comes below its lean again.
        """
        decay, weight = self._gains.steadiness, self._gains.steady_weight
        moving = objectives.linear_momentum(
            view, -decay * view.linear_momentum, weight * np.array([0.0, 1.0, 1.0])
        )
        if self._gains.steer_weight > 0.0:
            return moving, Axle.of(view).objective(view, self._gains, speed)
        turning = objectives.angular_momentum(
            view, -decay * view.angular_momentum, weight * np.array([1.0, 0.0, 1.0])
        )
        return moving, turning

    def _shape(self, view: BodyView, shape: MeanShape, ahead: float) -> Objective:
        """Tilt that brings the weight ahead of the contact, ``ahead`` over its height; no squash.

        A rigid ellipse, but little out of round, has its lowest point at twice its tilt times its
        height behind its middle.
        """
        g = self._gains
        rates = g.shape_follow * np.array([0.5 * g.tilt_gain * ahead - shape.tilt, -shape.squash])
        weight = np.array([g.tilt_weight, g.squash_weight]) / view.horizon
        return shape.objective(view, rates, weight)

    def _let_go(self, view: BodyView, units: BodyUnits, since: float) -> Goals | None:
        release = self._gains.release
        if since >= LET_GO * release:
            return None
        # Without objectives a step takes a share dt / (dt + release) of the contraction away.
        return Goals(
            objectives=(),
            patches=self._patches(view),
            activation=ActivationCost(effort=1.0, change=release / units.time),
        )

    def _patches(self, view: BodyView) -> tuple[Patch, ...]:
        self._last = clustered_patches(
            view, count=self._count, region=self._rim, parts=self._parts, last=self._last
        )
        return self._last
