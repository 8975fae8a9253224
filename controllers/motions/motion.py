"""A motion of a sequence, and when it is over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.arguments import suited_by
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.inner_controllers import says, told_by
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.view import BodyView


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A motion of a sequence, and when it is over: at the first of its ends that comes.

    Without any it is over when its controller says so by an attribute ``finished``, as `Jump`,
    `Roll` and `Exercise` do. A way ends none whose controller ``stays`` in its place, as `Balance`
    and jumps on the spot do.

    Attributes:
        controller: that moves the body meanwhile.
        seconds: s, after which it is over.
        distance: m, along the ground, of the centre of mass from where it began.
        until: function of a `BodyView`, whose time begins with the motion; over once it is true.
        name: in what is told of the run; None for that of the controller's class.
    """

    controller: Controller
    seconds: float | None = None
    distance: float | None = None
    until: Callable[[BodyView], bool] | None = None
    name: str | None = None

    def __post_init__(self) -> None:
        """Refuse what is no controller, and ends that never come or come at once."""
        told_by(input_kinds.controller("Motion.controller", self.controller))
        if self.name is not None:
            input_kinds.name("Motion.name", self.name)
        for field, unit in (("seconds", "s"), ("distance", "m")):
            value = getattr(self, field)
            if value is not None:
                label = f"Motion.{field}"
                checks.keep(self, **{field: checks.number(label, value, above=0.0, unit=unit)})
        others = (self.seconds, self.until)
        if self.distance is not None and others == (None, None) and says(self.controller, "stays"):
            raise InputError(
                f"{self.title} stays in its place, so that a way of {self.distance:g} m never ends "
                f"it: let it end after seconds, as {self.title}:5s"
            )
        if self.until is not None:
            checks.called_with("Motion.until", self.until, 1, "a function of a view")

    @property
    def title(self) -> str:
        """What it is called."""
        suited = suited_by(self.controller)
        kind = type(self.controller) if suited is None else suited[0]
        return self.name or kind.__name__.lower()

    @property
    def ends(self) -> bool:
        """Whether it ever ends."""
        given = (self.seconds, self.distance, self.until)
        return any(end is not None for end in given) or hasattr(self.controller, "finished")

    def is_over(self, view: BodyView, start: FloatArray, controller: Any) -> bool:
        """Whether it is over in a step of its own time, for a body that began at ``start``, m."""
        if self.seconds is not None and view.time >= self.seconds - 0.5 * view.time_step:
            return True
        if self.distance is not None:
            way = (view.center_of_mass - start)[:2]
            if float(np.hypot(*way)) >= self.distance:
                return True
        if self.until is not None and checks.truth("what Motion.until returns", self.until(view)):
            return True
        only = self.seconds is None and self.distance is None and self.until is None
        return only and says(controller, "finished")
