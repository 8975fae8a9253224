"""What a shipped scene is made of: its recipe with numbers to set, and the plan it becomes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches

from warp_softbody.controllers.controller import Controller
from warp_softbody.errors import InputError
from warp_softbody.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A number that the user may set.

    Attributes:
        name: as in ``--set name=value``.
        default: value where none is given.
        low, high: range, both ends included.
        unit: for people; empty for a pure number.
        help: one line.
    """

    name: str
    default: float
    low: float
    high: float
    unit: str = ""
    help: str

    def parse(self, value: str | float) -> float:
        """The number that a text or a number stands for, if it lies in the range."""
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not self.low <= number <= self.high:
            unit = f" {self.unit}" if self.unit else ""
            raise InputError(
                f"setting {self.name!r} must be a number from {self.low:g} to {self.high:g}{unit}, "
                f"got {value!r}"
            )
        return number


@dataclass(frozen=True, kw_only=True)
class ScenePlan:
    """A scene ready to be run.

    Attributes:
        name: as in ``warp-softbody run``.
        description: one line.
        scene: what there is.
        controller: what is wanted of it, fresh for one run; None for a passive body.
        seconds: usual length, s.
        time_step: usual time step, s.
        settings: every setting as used.
    """

    name: str
    description: str
    scene: Scene
    controller: Controller | None
    seconds: float
    time_step: float
    settings: Mapping[str, float]


Values = Mapping[str, float]
Build = Callable[[Values], tuple[Scene, Controller | None]]


@dataclass(frozen=True, kw_only=True)
class SceneRecipe:
    """A shipped scene before its numbers are set.

    Attributes:
        name: as in ``warp-softbody run``.
        description: one line.
        settings: what can be set.
        build: the scene and a fresh controller for given settings.
        seconds: usual length, s.
        time_step: usual time step, s.
    """

    name: str
    description: str
    settings: tuple[Setting, ...] = ()
    build: Build
    seconds: float
    time_step: float = 0.01

    def make(self, given: Mapping[str, str | float]) -> ScenePlan:
        """The plan for the settings given; the others take their defaults."""
        values = self._values(given)
        scene, controller = self.build(values)
        return ScenePlan(
            name=self.name,
            description=self.description,
            scene=scene,
            controller=controller,
            seconds=self.seconds,
            time_step=self.time_step,
            settings=values,
        )

    def _values(self, given: Mapping[str, str | float]) -> dict[str, float]:
        known = [setting.name for setting in self.settings]
        for name in given:
            if name not in known:
                raise InputError(
                    f"scene {self.name!r} has no setting {name!r}; {suggestion(name, known)}"
                )
        return {
            setting.name: setting.parse(given.get(setting.name, setting.default))
            for setting in self.settings
        }


def suggestion(name: str, known: list[str]) -> str:
    """What may have been meant, and all that there is."""
    close = get_close_matches(name, known, n=3, cutoff=0.6)
    meant = f"did you mean {' or '.join(map(repr, close))}? " if close else ""
    return f"{meant}known: {', '.join(known) or 'none'}"
