"""What is taught: a motion of a character, how long it is tried, and on which grounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.controllers.controller import Controller
from warp_softbody.inputs import checks
from warp_softbody.scenes.doings import DOINGS
from warp_softbody.scenes.plan import Setting
from warp_softbody.teaching.ranges import WANTED, Field

ENDLESS = {"jumps": 100.0, "turn": 1000.0}
"""Settings with which a motion does not end while it is tried."""

FRICTIONS = (0.8, 0.5)
"""Of the grounds on which every try is made: the worse one counts."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """A motion that a character is to learn: to go as far as it can, upright where it stands.

    Attributes:
        character: that learns.
        do: "walk", "crawl", "hop" or "roll".
        seconds: of a try.
        time_step: of a try, s.
        frictions: of the grounds of a try.
    """

    character: Character
    do: str
    seconds: float = 8.0
    time_step: float = 1.0 / 60.0
    frictions: tuple[float, ...] = field(default=FRICTIONS)

    def __post_init__(self) -> None:
        """Refuse what cannot be taught.

        Raises:
            InputError: there is no such motion, or the body cannot do it.
        """
        checks.instance("Task.character", self.character, Character)
        checks.choice("Task.do", self.do, WANTED)
        checks.settle(self, positive=("seconds", "time_step"))
        self.controller({})

    @property
    def values(self) -> dict[str, float]:
        """Settings of the motion, with which it does not end by itself."""
        own: tuple[Setting, ...] = DOINGS[self.do].settings
        return {setting.name: ENDLESS.get(setting.name, setting.default) for setting in own}

    @property
    def field(self) -> Field:
        """Where its gains are looked for."""
        return Field(self.usual, WANTED[self.do])

    @property
    def usual(self) -> Any:
        """The gains that it has without being taught."""
        find = DOINGS[self.do].usual
        assert find is not None
        return find(self.character, self.values)

    def controller(self, numbers: Mapping[str, float]) -> Controller:
        """A controller with some of the gains' numbers, by path; the usual ones for none."""
        doing = DOINGS[self.do]
        gains = doing.gains(self.character, self.values, numbers)
        return doing.make(self.character, self.values, gains)

    @property
    def length(self) -> float:
        """Of the body, m."""
        return float(np.ptp(self.character.mesh.bounds, axis=0).max())
