"""Balance: an upright body, momenta and the base (docs/method.md section 4)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.any_body import feet_of, require_muscles, require_regions
from warp_softbody.controllers.motions.balance_gains import ANY_BODY, BalanceGains
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES, mean_weights, region_mean
from warp_softbody.controllers.motions.for_any_body.support import hull, reach, room
from warp_softbody.controllers.motions.recovery import Recovery, RecoveryPhase, Tipping
from warp_softbody.controllers.motions.standing_body import (
    middle_at_rest,
    sole_triangles,
    stance_of,
)
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.inputs.records import unchecked_copy
from warp_softbody.world.view import BodyView

__all__ = ["Balance", "BalanceGains"]

SKIP_DEPTH = 0.45
"""Share of its height at rest by which a skipping body wants to shorten: more than it can."""
SKIP_WEIGHT = 20.0
"""Of the head's height in a skip, over `BalanceGains.upright_weight`."""
SKIP_ACCELERATION = 8.0
"""g, of the head against the base in a skip: enough to lift the edge that a body stands on."""

LEAST_HEIGHT = 1e-3
"""L, of the centre of mass above the base, with which a lying body's capture point is reckoned."""


NARROW = 0.15
"""Least way from under the centre of mass to the edge of a sole, over that centre's height, below
which a body that stands is not asked to rise. It has sagged below its height at rest, which fibres
that only shorten cannot give back to it: a plan that keeps trying bends it until it tips."""

RISE_WITHIN = 0.1
"""L, `BalanceGains.height_within` of a body on a narrow sole."""

YIELDING = 0.4
"""Of the way to the edge of the sole, beyond `BalanceGains.hold_within`, over which the base comes
to be moved under the head with all its weight."""

LYING = 0.5
"""Height over length of a body below which it has no head to hold up."""


class _Lever(NamedTuple):
    """What stays of the head over the base from step to step.

    Attributes:
        weights: (n,), of the difference of their means.
        rest: (3,) m, that difference at rest.
        slopes: (2, n), weights of heights in how far the base's slopes carry the head, along x, y.
        rows: (3, 3n), of the objective.
        base_rows: (2, 3n), what rows along x and y have of the base, with the opposite sign.
        sole: (h, 2) m, corners around where the centre of mass belongs.
    """

    weights: FloatArray
    rest: FloatArray
    slopes: FloatArray
    rows: FloatArray
    base_rows: FloatArray
    sole: FloatArray


@remembered
class Balance:
    """Keeps the head and the centre of mass above the base and the body from turning."""

    required_regions = ("base", "head")
    """Regions that `for_` needs of a character."""

    keeps_upright = True
    """A run in which the body falls is said to be doubtful."""

    def __init__(
        self,
        gains: BalanceGains | None = None,
        *,
        base: str = "base",
        head: str = "head",
        patches: tuple[str, ...] = BASE_PATCHES,
        stance: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Balance on a base region, thinking of the ground through patch regions of it.

        The region ``head`` is asked for only where `BalanceGains.upright_weight` is positive.
        ``stance`` (2,) L is where the centre of mass belongs over the base, from the mean of its
        nodes: that of a body which is not symmetric is not in the middle.
        """
        self._gains = checks.optional("gains of Balance", gains, BalanceGains)
        self._base = input_kinds.name("base of Balance", base)
        self._head = input_kinds.name("head of Balance", head)
        self._patches = input_kinds.names("patches of Balance", patches)
        x, y = checks.vector("stance of Balance", stance, 2, unit="L")
        self._stance = np.array([x, y, 0.0])
        self._units: BodyUnits | None = None
        self._height: float | None = None
        self._head_over_base: _Lever | None = None
        self._triangles: np.ndarray[tuple[int, ...], np.dtype[np.int32]] | None = None
        self._recovery = Recovery(self._base, self._head, self._patches)

    @property
    def stays(self) -> bool:
        """That it goes nowhere."""
        return True

    @classmethod
    def for_(cls, character: Character, gains: BalanceGains | None = None) -> Balance:
        """Balance of any body, on its feet.

        Args:
            character: has nodes in the regions `required_regions`; it stands through its regions
                `foot_...`, or of fewer than three the quadrants `base_patch_...` of its base.
            gains: None for `ANY_BODY`.

        Raises:
            InputError: the body lacks a region or has no muscles.
        """
        require_regions("Balance", character, cls.required_regions)
        require_muscles("Balance", character)
        feet = feet_of(character)
        if gains is None:
            narrow = (
                room(character.mesh.points[character.region("base")], middle_at_rest(character))
                < NARROW
            )
            gains = replace(ANY_BODY, height_within=RISE_WITHIN) if narrow else ANY_BODY
        # Feet apart from each other do not widen, and a sole of points has no area.
        apart = any(name.startswith("foot_") for name in character.regions)
        if apart or not len(sole_triangles(character, "base")):
            gains = replace(gains, base_weight=0.0)
        x, y, height = np.ptp(character.mesh.bounds, axis=0)
        if height < LYING * max(x, y):
            gains = replace(gains, upright_weight=0.0)
        return cls(gains, patches=feet, stance=stance_of(character))

    @property
    def interruptible(self) -> bool:
        """Whether it stands, and is not on its way to where it will stand again."""
        return self._recovery.phase is RecoveryPhase.STAND

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        target = self._over_base(view)
        g = self._gains
        ahead = self._capture_point(view, target)
        if g.recovery.leave > 0.0:
            hops = self._recovery.goals(view, g.recovery, self._fall(view, target, ahead))
            if hops is not None:
                return hops
        offset = math.hypot(*ahead)
        assert self._height is not None
        target[2] += self._height - min(g.crouch * offset, 0.3 * self._height)
        pull = view.mass * g.position * (target - view.center_of_mass)
        rate = pull - g.velocity * view.linear_momentum
        wanted = [
            objectives.linear_momentum(view, rate, g.momentum_weight),
            objectives.angular_momentum(view, -g.spin * view.angular_momentum, g.spin_weight),
        ]
        if g.upright_weight > 0.0:
            wanted.append(self._upright(view, ahead, offset))
        if g.base_weight > 0.0:
            wanted.append(self._widen(view, g.base_rate * offset))
        return Goals(
            objectives=tuple(wanted),
            patches=ground_patches(view, self._patches),
            activation=self._relaxed(offset),
        )

    def tipping(self, view: BodyView) -> Tipping:
        """How a body is about to fall that is seen from ``view``, the first of them at rest."""
        view = seen(view)
        base = self._over_base(view)
        return self._fall(view, base, self._capture_point(view, base))

    def _over_base(self, view: BodyView) -> FloatArray:
        """Where (3,) m the centre of mass belongs, at the height of the base; SI from now on.

        Raises:
            InputError: the scene has no gravity.
        """
        objectives.weight_of(view)
        if self._units is None:
            self._units = BodyUnits.of(view)
            self._gains = in_si(self._gains, self._units)
            self._stance *= self._units.length
        target = region_mean(view, view.positions, self._base) + self._stance
        if self._height is None:
            self._height = float((view.center_of_mass - target)[2])
        return np.asarray(target)

    def _upright(
        self, view: BodyView, ahead: np.ndarray[tuple[int, ...], Any], offset: float
    ) -> objectives.Objective:
        """The head comes back to its place over the base, at the height that is wanted."""
        g, lever = self._gains, self._lever(view)
        rest, now = lever.rest, lever.weights @ view.positions
        way = g.upright * (rest - now)
        way[:2] -= g.upright * (lever.slopes @ view.positions[:, 2] + g.lean * ahead)
        skips = offset > g.skip_from
        speed = float(lever.weights @ view.velocities[:, 2])
        way[2] = self._rising(view, float(now[2]), speed, float(rest[2]), offset, skips=skips)
        height = SKIP_WEIGHT if skips else g.height_weight
        return objectives.Objective(
            name="upright",
            rows=self._upright_rows(lever, ahead, offset),
            target=way / (view.gravity * view.horizon),
            weight=g.upright_weight * np.array([1.0, 1.0, height]),
        )

    def _upright_rows(self, lever: _Lever, ahead: FloatArray, offset: float) -> FloatArray:
        """Rows in which the base counts the more, the nearer the capture point is to its edge."""
        hold = self._gains.hold_within
        if hold == 0.0:
            return lever.rows
        share = offset / max(reach(lever.sole, ahead), LEAST_HEIGHT * offset, 1e-12)
        kept = 1.0 - min(max((share - hold) / YIELDING, 0.0), 1.0)
        rows: FloatArray = lever.rows.copy()
        rows[:2] += kept * lever.base_rows
        return rows

    def _lever(self, view: BodyView) -> _Lever:
        """What stays of the head over the base."""
        if self._head_over_base is None:
            character = view.scene.character
            points, base = character.mesh.points, mean_weights(view, (self._base,))
            weights = mean_weights(view, (self._head,)) - base
            rest = weights[: len(points)] @ points
            slopes = self._gains.follow * rest[2] * self._slopes(view)
            rows = objectives.mean_rows(view, weights).reshape(3, -1, 3)
            rows[:2, :, 2] += slopes
            unit = view.gravity * view.horizon
            rows /= unit
            sole = points[character.region(self._base), :2]
            self._head_over_base = _Lever(
                weights,
                rest,
                slopes,
                rows.reshape(3, -1),
                objectives.mean_rows(view, base)[:2] / unit,
                hull(sole - sole.mean(axis=0) - self._stance[:2]),
            )
        return self._head_over_base

    def _rising(
        self,
        view: BodyView,
        height: float,
        speed: float,
        rest: float,
        offset: float,
        *,
        skips: bool,
    ) -> float:
        """The wanted speed (m/s) at which the head rises over the base, from a height, m."""
        g = self._gains
        squat = rest - min(g.squat * offset, (1.0 - g.least_height) * rest)
        goal = (1.0 - SKIP_DEPTH) * rest if skips else squat
        share = SKIP_ACCELERATION if skips else g.height_acceleration
        change = share * view.gravity * view.horizon
        if offset < g.height_within and not skips:
            goal = min(goal, height + offset / g.height_within * (goal - height))
        return min(max(g.height_rate * (goal - height), speed - change), speed + change)

    def _slopes(self, view: BodyView) -> np.ndarray[tuple[int, ...], Any]:
        """Weights (2, n), 1/m, of the nodes' heights in the slopes of the base along x and y."""
        character = view.scene.character
        nodes = character.region(self._base)
        around = character.mesh.points[nodes, :2] - character.mesh.points[nodes, :2].mean(axis=0)
        slopes = np.zeros((2, view.node_count))
        spread = np.square(around).sum(axis=0)
        # A base of one point or one line has no slope across it.
        slopes[:, nodes] = (around / np.where(spread > 0.0, spread, np.inf)).T
        return slopes

    def _relaxed(self, offset: float) -> ActivationCost:
        g = self._gains
        share = max(0.0, 1.0 - offset / g.relax_within)
        effort = g.activation.effort * (1.0 + g.relax * share)
        return unchecked_copy(g.activation, effort=effort)

    def _capture_point(
        self, view: BodyView, base: np.ndarray[tuple[int, ...], Any]
    ) -> np.ndarray[tuple[int, ...], Any]:
        """Where (2,) m the capture point c + v sqrt(h / g) is, from the base's middle."""
        over = view.center_of_mass - base
        height = max(float(over[2]), LEAST_HEIGHT * BodyUnits.of(view).length)
        time = math.sqrt(height / max(view.gravity, 1e-6))
        return np.asarray((over + view.linear_momentum * (time / view.mass))[:2])

    def _fall(self, view: BodyView, base: FloatArray, ahead: FloatArray) -> Tipping:
        """How the body is about to fall, for its recovery."""
        height = float((view.center_of_mass - base)[2])
        least = LEAST_HEIGHT * BodyUnits.of(view).length
        return Tipping(
            ahead=ahead,
            speed=view.linear_momentum[:2] / view.mass,
            fall=math.sqrt(max(height, least) / max(view.gravity, 1e-6)),
            sole=self._lever(view).sole,
            height=height / max(self._height or 0.0, least),
        )

    def _widen(self, view: BodyView, growth: float) -> objectives.Objective:
        if self._triangles is None:
            self._triangles = sole_triangles(view.scene.character, self._base)
        return objectives.base_area(view, self._triangles, growth, self._gains.base_weight)
