"""A `SceneRecipe` lists the settings of a shipped scene; with values it makes a `ScenePlan`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches

from warp_softbody.controllers.controller import Controller
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds
from warp_softbody.world.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A number of a scene that the user may set.

    Attributes:
        name: as in ``--set name=value``.
        default: value where none is given.
        low, high: range, both ends included.
        unit: for people; empty for a pure number.
        help: one line.
        whole: whether it counts something, so that 1.7 is none.
    """

    name: str
    default: float
    low: float
    high: float
    unit: str = ""
    help: str
    whole: bool = False

    def __post_init__(self) -> None:
        """Refuse a range that the default is not in."""
        input_kinds.name("Setting.name", self.name)
        checks.settle(self, finite=("low", "high"))
        label = f"Setting.default of {self.name!r}"
        checks.keep(self, default=checks.number(label, self.default, low=self.low, high=self.high))
        input_kinds.text("Setting.unit", self.unit)
        input_kinds.text("Setting.help", self.help)
        checks.truth("Setting.whole", self.whole)

    def parse(self, value: str | float) -> float:
        """Return the number that a text or a number stands for, if it lies in the range."""
        try:
            number = float(value) if isinstance(value, str) else checks.number(self.name, value)
        except ValueError:
            number = math.nan
        if not self.low <= number <= self.high or (self.whole and not number.is_integer()):
            unit = f" {self.unit}" if self.unit else ""
            kind = "whole number" if self.whole else "number"
            raise InputError(
                f"setting {self.name!r} must be a {kind} from {self.low:g} to {self.high:g}{unit}, "
                f"got {checks.shown(value)}"
            )
        return number


@dataclass(frozen=True, kw_only=True)
class ScenePlan:
    """A scene with its controller, ready to be run.

    Attributes:
        name: as in ``warp-softbody run``.
        description: one line.
        scene: what there is.
        controller: what is wanted of it, fresh for one run; None for a passive body.
        seconds: usual length, s.
        time_step: usual time step, s.
        settings: every setting as used.
        others: controllers of bodies beside the character, by their names, likewise.
    """

    name: str
    description: str
    scene: Scene
    controller: Controller | None
    seconds: float
    time_step: float
    settings: Mapping[str, float]
    others: Mapping[str, Controller] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what cannot be run."""
        input_kinds.name("ScenePlan.name", self.name)
        input_kinds.text("ScenePlan.description", self.description)
        checks.instance("ScenePlan.scene", self.scene, Scene)
        if self.controller is not None:
            input_kinds.controller("ScenePlan.controller", self.controller)
        checks.settle(self, positive=("seconds", "time_step"))
        input_kinds.mapping("ScenePlan.settings", self.settings)
        for body, other in input_kinds.mapping("ScenePlan.others", self.others).items():
            input_kinds.controller(f"controller of {body!r} in ScenePlan.others", other)


Values = Mapping[str, float]
Build = Callable[[Values], tuple[Scene, Controller | None]]


@dataclass(frozen=True, kw_only=True)
class SceneRecipe:
    """A shipped scene with settings that may be given.

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

    def __post_init__(self) -> None:
        """Refuse what no plan can be made of."""
        input_kinds.name("SceneRecipe.name", self.name)
        input_kinds.text("SceneRecipe.description", self.description)
        settings = checks.items("SceneRecipe.settings", self.settings, Setting)
        input_kinds.distinct(f"settings of scene {self.name!r}", (s.name for s in settings))
        checks.keep(self, settings=settings)
        checks.function("SceneRecipe.build", self.build, "a function of the settings' values")
        checks.settle(self, positive=("seconds", "time_step"))

    def make(self, given: Mapping[str, str | float]) -> ScenePlan:
        """Return the plan for the settings given; the others take their defaults."""
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
        for name in input_kinds.mapping(f"settings of scene {self.name!r}", given):
            if not isinstance(name, str):
                checks.refuse(f"name of a setting of scene {self.name!r}", "a text", name)
            if name not in known:
                raise InputError(
                    f"scene {self.name!r} has no setting {checks.shown(name)}; "
                    f"{suggestion(name, known)}"
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
