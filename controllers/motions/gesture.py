"""A part of the body swings beside whatever else it does: for `Combined`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import objectives
from warp_softbody.controllers.arguments import remembered
from warp_softbody.controllers.body_units import BodyUnits, dimension, in_si
from warp_softbody.controllers.controller import ActivationCost, Goals, seen
from warp_softbody.controllers.motions.body_measures import mean_weights
from warp_softbody.controllers.motions.exercise import Sway
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView


@dataclass(frozen=True, kw_only=True)
class GestureGains:
    """Gains and weight of swinging a part, in units of the body (`BodyUnits`).

    Attributes:
        position: sqrt(g/L), how fast the part comes back to its path.
        velocity: sqrt(g/L), how fast its velocity comes near the one that is wanted.
        weight: of its velocity against that of the body, in units of g dt.
        activation: cost of effort and change, where nothing else is wanted of the body.
    """

    position: float = field(default=4.0, metadata=dimension(time=-1.0))
    velocity: float = field(default=10.0, metadata=dimension(time=-1.0))
    weight: float = 0.01
    activation: ActivationCost = field(default_factory=ActivationCost)

    def __post_init__(self) -> None:
        """Refuse gains that are not finite or out of their range."""
        checks.settle(self, not_negative=("position", "velocity", "weight"))
        checks.instance("GestureGains.activation", self.activation, ActivationCost)


@remembered
class Gesture:
    """The mean of a region swings along a direction, from its place at rest against the body.

    It plans without contacts, so that it is for `Combined`, behind a controller that stands.
    """

    def __init__(
        self,
        gains: GestureGains | None = None,
        *,
        region: str,
        direction: tuple[float, float, float] = (0.0, 0.0, 1.0),
        path: Sway | None = None,
        start: float = 0.0,
    ) -> None:
        """Swing a region along a direction by a path, from ``start`` sqrt(L/g) on."""
        self._gains = checks.optional("gains of Gesture", gains, GestureGains)
        self._region = input_kinds.name("region of Gesture", region)
        self._along = np.array(checks.direction("direction of Gesture", direction))
        self._path = checks.optional("path of Gesture", path, Sway)
        self._start = checks.number("start of Gesture", start, low=0.0, unit="sqrt(L/g)")
        self._units: BodyUnits | None = None
        self._weights: FloatArray = np.zeros(0)
        self._rest = 0.0
        self._finished = False

    @property
    def finished(self) -> bool:
        """Whether the path has died away."""
        return self._finished

    def goals(self, view: BodyView) -> Goals:
        """Objectives of the step from ``view`` on."""
        view = seen(view)
        if self._units is None:
            self._begin(view, BodyUnits.of(view))
        g, path = self._gains, self._path
        since = view.time - self._start
        self._finished = since >= path.period * path.periods + path.ease
        place, speed, _ = path.at(since)
        now = float(self._weights @ view.positions @ self._along) - self._rest
        moves = float(self._weights @ view.velocities @ self._along)
        way = speed + g.position * (place - now)
        soon = moves + view.horizon * g.velocity * (way - moves)
        unit = objectives.weight_of(view) / view.mass * view.horizon
        rows = self._along @ objectives.mean_rows(view, self._weights / unit)
        swings = objectives.Objective(
            name=f"gesture of {self._region}",
            rows=rows.reshape(1, -1),
            target=np.array([soon / unit]),
            weight=np.array([g.weight]),
        )
        return Goals(objectives=(swings,), activation=g.activation)

    def _begin(self, view: BodyView, units: BodyUnits) -> None:
        self._units = units
        self._gains = in_si(self._gains, units)
        self._path = in_si(self._path, units)
        self._start *= units.time
        self._weights = mean_weights(view, (self._region,)) - view.masses / view.mass
        points = view.scene.character.mesh.points
        self._rest = float(self._weights[: len(points)] @ points @ self._along)
