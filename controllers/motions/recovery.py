"""Recovery by leaving the base: hops that bring it under a body which falls (docs/method.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.controller import Goals
from warp_softbody.controllers.motions.body_measures import (
    mean_weights,
    moments_of_inertia,
    region_mean,
)
from warp_softbody.controllers.motions.for_any_body.support import reach
from warp_softbody.controllers.motions.outer_push import OuterPush
from warp_softbody.controllers.motions.recovery_gains import RecoveryGains
from warp_softbody.controllers.objectives import Objective
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.world.view import BodyView

NEARLY = 0.94
"""Share of the wanted rising speed from which on the base is lifted."""

LEAST_PHASE = 0.1
"""sqrt(L/g), for which a push or a flight lasts at least: an edge that bounces ends neither."""

LOST = 0.6
"""Share of its height at rest below which a body has fallen, and hops no more."""


class RecoveryPhase(Enum):
    """What a body that recovers is doing."""

    STAND = "stand"
    BRACE = "brace"
    GATHER = "gather"
    PUSH = "push"
    FLY = "fly"


@dataclass(frozen=True, kw_only=True)
class Tipping:
    """How a body is about to fall.

    Attributes:
        ahead: (2,) m, its capture point, from where the centre of mass belongs over the base.
        speed: (2,) m/s, of the centre of mass along the ground.
        fall: s, sqrt(h / g).
        sole: (h, 2) m, corners of the sole around where the centre of mass belongs.
        height: of the centre of mass over the base, as a share of that at rest.
    """

    ahead: FloatArray
    speed: FloatArray
    fall: float
    sole: FloatArray
    height: float

    def share(self, way: FloatArray) -> float:
        """A way (2,) m over that to the edge of the sole on its side."""
        size = math.hypot(*way)
        return size / max(reach(self.sole, way), 1e-3 * size, 1e-12)

    @property
    def side(self) -> FloatArray:
        """Unit vector (2,) along which the capture point is off."""
        size = math.hypot(*self.ahead)
        return self.ahead / size if size > 0.0 else np.array([1.0, 0.0])


class Recovery:
    """Hops of a body whose capture point is carried beyond its base, until it is within it."""

    def __init__(self, base: str, head: str, patches: tuple[str, ...]) -> None:
        """Of a base region, a head over it, and the patches on which it stands."""
        self._base = base
        self._head = head
        self._patches = patches
        self._push = OuterPush()
        self._decided = False
        self._since = 0.0
        self.phase = RecoveryPhase.STAND
        self.hops = 0

    def goals(self, view: BodyView, gains: RecoveryGains, fall: Tipping) -> Goals | None:
        """Objectives of the step, with gains in SI units; None while the base need not be left."""
        self._push.see(view)
        self._advance(view, gains, fall)
        if self.phase is RecoveryPhase.STAND:
            return None
        grounded = self.phase in (RecoveryPhase.BRACE, RecoveryPhase.PUSH)
        wanted = self._leave(view, gains, fall) if grounded else self._reach(view, gains, fall)
        return Goals(
            objectives=wanted,
            patches=ground_patches(view, self._patches) if grounded else (),
            activation=gains.activation,
        )

    def leave(self, view: BodyView) -> None:
        """Leave the base, wherever the capture point is: the base is drawn up at once."""
        self._decided = True
        self._enter(RecoveryPhase.GATHER, view)

    def _advance(self, view: BodyView, g: RecoveryGains, fall: Tipping) -> None:
        elapsed = view.time + 0.5 * view.time_step - self._since
        least = LEAST_PHASE * BodyUnits.of(view).time
        airborne, rising = not view.touching.any(), float(view.linear_momentum[2]) / view.mass
        if fall.height < LOST:
            self._decided = False
            self._enter(RecoveryPhase.STAND, view)
        elif self.phase is RecoveryPhase.STAND:
            self._begin(view, g, fall)
        elif self.phase is RecoveryPhase.BRACE:
            if elapsed >= g.brace:
                self._enter(RecoveryPhase.GATHER, view)
        elif self.phase is RecoveryPhase.GATHER:
            if elapsed >= g.gather_time and not airborne:
                self._land(view, g, fall)
        elif self.phase is RecoveryPhase.PUSH:
            off = airborne and elapsed >= least
            if off or rising >= NEARLY * g.rise or elapsed >= g.push_time:
                self._enter(RecoveryPhase.FLY, view)
        elif elapsed >= g.fly_time or (elapsed >= least and not airborne and rising < 0.0):
            self._land(view, g, fall)

    def _begin(self, view: BodyView, g: RecoveryGains, fall: Tipping) -> None:
        """Leave the base if the capture point will leave it, and has come some way there."""
        lasts = max(g.still, g.expect - self._push.lasted) if self._push.lasted else g.still
        carried = self._push.carried(fall.ahead, fall.speed, fall.fall, lasts)
        self._decided = self._decided or fall.share(carried) > g.leave
        if self._decided and fall.share(fall.ahead) > g.start:
            self._enter(RecoveryPhase.BRACE, view)

    def _enter(self, phase: RecoveryPhase, view: BodyView) -> None:
        self.phase = phase
        self._since = view.time

    def _land(self, view: BodyView, g: RecoveryGains, fall: Tipping) -> None:
        """Push off again, or stay, where the capture point is caught."""
        self.hops += 1
        caught = fall.share(fall.ahead) <= g.settle
        self._decided = not caught
        self._enter(RecoveryPhase.STAND if caught else RecoveryPhase.PUSH, view)

    def _leave(self, view: BodyView, g: RecoveryGains, fall: Tipping) -> tuple[Objective, ...]:
        """Momenta of take-off, and a head that leans back."""
        goal = view.mass * np.array([*(g.keep * fall.speed), g.rise])
        x, y = fall.side
        inertia = moments_of_inertia(view)
        back = -g.spin * float(inertia[0] * y * y + inertia[1] * x * x) * np.array([-y, x, 0.0])
        weights = np.array([g.way_weight, g.way_weight, g.rise_weight])
        return (
            objectives.linear_momentum(view, g.push * (goal - view.linear_momentum), weights),
            objectives.angular_momentum(
                view, g.push_spin * (back - view.angular_momentum), g.spin_weight
            ),
            self._lean(view, g, fall),
        )

    def _lean(self, view: BodyView, g: RecoveryGains, fall: Tipping) -> Objective:
        head, base = (region_mean(view, view.positions, one) for one in (self._head, self._base))
        way = -g.lean * fall.side - (head - base)[:2]
        weights = mean_weights(view, (self._head,)) - mean_weights(view, (self._base,))
        unit = view.gravity * view.horizon
        return Objective(
            name="lean",
            rows=objectives.mean_rows(view, weights)[:2] / unit,
            target=g.lean_rate * way / unit,
            weight=np.full(2, g.lean_weight),
        )

    def _reach(self, view: BodyView, g: RecoveryGains, fall: Tipping) -> tuple[Objective, ...]:
        """The base comes to where it is to land, as seen from the centre of mass."""
        gathers = self.phase is RecoveryPhase.GATHER
        ahead, height, tilt = (
            (g.gather_ahead, g.gather_height, g.gather_tilt)
            if gathers
            else (g.ahead, g.height, g.tilt)
        )
        place = np.array([*(ahead * fall.fall * fall.speed + g.further * fall.side), -height])
        middle, base = view.masses / view.mass, mean_weights(view, (self._base,))
        own = [mean_weights(view, (name,)) for name in self._patches]
        parts = [(base, 0), (base, 1), *((weights, 2) for weights in own)]
        rest = view.scene.character.mesh.points
        rows, target = np.zeros((len(parts), view.node_count, 3)), np.zeros(len(parts))
        for number, (weights, axis) in enumerate(parts):
            goal = float(place[axis])
            if axis == 2:
                beside = (weights - base)[: len(rest)] @ rest[:, :2]
                goal += tilt * float(beside @ fall.side)
            across = weights - middle
            rows[number, :, axis] = across
            target[number] = g.reach_rate * (goal - across @ view.positions[:, axis])
        share = 1.0 / BodyUnits.of(view).speed
        weight = np.full(len(parts), g.reach_weight)
        weight[2:] *= g.level_weight
        return (
            Objective(
                name="reach",
                rows=share * rows.reshape(len(parts), -1),
                target=share * target,
                weight=weight,
            ),
        )
