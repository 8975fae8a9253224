"""Sliding under a pull: lean against it, on whatever base the ground allows (docs/method.md 4)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES, angle_turned, region_mean
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView

MOST_LEARNT = 0.04
"""rad: no more of a tilt is learnt from, as one in which a limp body was found says nothing of the
pull; what was learnt too much would later tip the body the other way."""


@dataclass(frozen=True, kw_only=True)
class SlideGains:
    """Gains and weights of leaning against an unknown pull, in units of the body (`BodyUnits`).

    Only the turning is controlled: on a floor that slips linear momentum is the ground's to give,
    and a plan that asks for it presses and lifts the foot in turn for more friction.

    Attributes:
        tilt: g/L, of the tilt from the one wanted, and of the heading from that at rest.
        spin: sqrt(g/L), decay of angular momentum.
        learning: (g/L)^(3/2), how fast the torque of the pull is learnt from the tilt that is left.
        lean: share of the learnt torque that the weight of the leaning body is to balance.
        furthest: L, bound on how far the centre of mass leans.
        spin_weight: of the angular momentum, in units of m g L dt.
        activation: cost of effort and change.
    """

    tilt: float = field(default=14.27, metadata=dimension(time=-2.0))
    spin: float = field(default=6.386, metadata=dimension(time=-1.0))
    learning: float = field(default=6.509, metadata=dimension(time=-3.0))
    lean: float = 0.6
    furthest: float = field(default=0.12, metadata=dimension(length=1.0))
    spin_weight: float = 30.0
    activation: ActivationCost = field(
        default_factory=lambda: ActivationCost(effort=0.4, change=0.3759)
    )

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        limits = ("tilt", "spin", "learning", "furthest", "spin_weight")
        checks.settle(self, not_negative=limits, finite=("lean",))
        checks.instance("SlideGains.activation", self.activation, ActivationCost)


@remembered
class Slide:
    """Keeps upright on a base that slides, and leans against what pulls."""

    def __init__(
        self,
        gains: SlideGains | None = None,
        *,
        start: float = 0.0,
        base: str = "base",
        head: str = "head",
        patches: tuple[str, ...] = BASE_PATCHES,
    ) -> None:
        """Slack until ``start``, sqrt(L/g); tilt is measured from ``base`` to ``head``."""
        self._gains = checks.optional("gains of Slide", gains, SlideGains)
        self._start = checks.number("start of Slide", start, low=0.0, unit="sqrt(L/g)")
        self._base = input_kinds.name("base of Slide", base)
        self._head = input_kinds.name("head of Slide", head)
        self._patches = input_kinds.names("patches of Slide", patches)
        self._units: BodyUnits | None = None
        self._torque = np.zeros(3)

    def goals(self, view: BodyView) -> Goals | None:
        """Objectives of the step from ``view`` on; None before the start."""
        view = seen(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._start *= self._units.time
        if view.time < self._start:
            return None
        g = self._gains
        ahead = self._lean(view)
        tilt = self._tilt(view) + np.array([-ahead[1], ahead[0], 0.0]) / self._rest_height(view)
        turned = _inertia(view) @ tilt
        slow = min(1.0, MOST_LEARNT / max(float(np.linalg.norm(tilt)), 1e-9))
        self._torque += view.time_step * g.learning * slow * turned
        turn = -g.spin * view.angular_momentum - g.tilt * turned - self._torque
        return Goals(
            objectives=(objectives.angular_momentum(view, turn, g.spin_weight),),
            patches=ground_patches(view, self._patches),
            activation=g.activation,
        )

    def _lean(self, view: BodyView) -> FloatArray:
        """How far (m) the centre of mass is wanted behind the base, against the learnt torque."""
        g = self._gains
        ahead = (
            g.lean / objectives.weight_of(view) * np.array([self._torque[1], -self._torque[0], 0.0])
        )
        size = float(np.linalg.norm(ahead))
        return np.asarray(ahead * min(1.0, g.furthest / size) if size > 0.0 else ahead)

    def _tilt(self, view: BodyView) -> FloatArray:
        """Sines of the angles about x and y by which head over base has turned, and heading."""
        heading = angle_turned(view, 0, 1)
        cosine, sine = np.cos(heading), np.sin(heading)
        turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        rest = turn @ self._upward(view, view.scene.character.mesh.points)
        tilt = np.cross(rest, self._upward(view, view.positions))
        tilt[2] = heading
        return tilt

    def _upward(self, view: BodyView, points: FloatArray) -> FloatArray:
        way = region_mean(view, points, self._head) - region_mean(view, points, self._base)
        return np.asarray(way / np.linalg.norm(way))

    def _rest_height(self, view: BodyView) -> float:
        """Of the centre of mass above the base, m."""
        rest = view.scene.character.mesh.points[:, 2]
        base = view.scene.character.region(self._base)
        return float(view.masses[: len(rest)] @ rest / view.mass - rest[base].mean())


def _inertia(view: BodyView) -> FloatArray:
    """Moments of inertia about the centre of mass, (3, 3) kg m^2."""
    arms = view.positions - view.center_of_mass
    products = (arms * view.masses[:, None]).T @ arms
    return np.asarray(np.trace(products) * np.eye(3) - products)
