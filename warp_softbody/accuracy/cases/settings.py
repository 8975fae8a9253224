"""What one point of a chart is run with: mesh, time step and every option that costs time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from warp_softbody.controllers.control_options import ControlOptions
from warp_softbody.engine.options import (
    Cone,
    NamedElements,
    NamedTangent,
    Precision,
    SimulationOptions,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs.option_fields import Option, options_of

if TYPE_CHECKING:
    from warp_softbody.scenes import ScenePlan


@dataclass(frozen=True, kw_only=True)
class Settings:
    """A point's knobs.

    Those not listed are options of `SimulationOptions` and `ControlOptions`, which say under what
    name charts know them; None leaves an option as it is by default.

    Attributes:
        cells: the scene's setting of that name; None for its default, or where it has none.
        level: how often every tet of that mesh is cut into eight; below 0, how much coarser a mesh
            than usual the scene is asked for by its setting `coarse`. 0 is a letter's usual mesh,
            with the paper's number of tets, on whatever mesh the scene ships.
        patches: the scene's setting of that name; None for its default, or where it has none.
        preconditioner: "factor" or "two-level".
    """

    time_step: float
    cells: int | None = None
    level: int = 0
    elements: NamedElements = "linear"
    tangent: NamedTangent = "warped"
    precision: Precision = "float32"
    cone: Cone = "smooth"
    newton_iterations: int = 1
    tolerance: float | None = None
    threads: int = 1
    method: str = "qpcc"
    qps: int | None = None
    plan_cone: int | None = None
    patches: int | None = None
    preconditioner: str | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values by knob."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Settings:
        """Back from `to_dict`; a knob that is not known is refused."""
        unknown = sorted(set(values) - set(KNOBS))
        if unknown:
            raise InputError(f"settings name the knob {unknown[0]!r}; known: {', '.join(KNOBS)}")
        return cls(**values)

    @property
    def mesh(self) -> tuple[int | None, int]:
        """Cells and level, which together say how fine it is."""
        return self.cells, self.level

    @property
    def coarse(self) -> int:
        """The scene's setting of that name, where it has one; 0 for the usual mesh."""
        return max(0, -self.level)

    @property
    def refinements(self) -> int:
        """How often every tet is cut into eight."""
        return max(0, self.level)

    @property
    def possible(self) -> bool:
        """Whether the engine has this combination."""
        return self.elements == "linear" or self.tangent != "exact"

    def options(self) -> SimulationOptions:
        """Those of the engine."""
        return SimulationOptions(**self.chosen(SimulationOptions))

    def control_options(self) -> ControlOptions:
        """Those of the control solver."""
        return ControlOptions(**self.chosen(ControlOptions))

    def chosen(self, owner: type[Any]) -> dict[str, Any]:
        """Values of the options of a class that are not left as they are by default, by name."""
        knobs = {one.name: getattr(self, one.knob) for one in options_of(owner) if one.knob}
        return {name: as_option(value) for name, value in knobs.items() if value is not None}

    def plan(self, scene: str, given: Mapping[str, str | float]) -> ScenePlan:
        """The scene on this mesh; ``given`` are its other settings."""
        from warp_softbody import scenes
        from warp_softbody.world.refined_scene import refined_scene

        plan = scenes.make(scene, {**given, **self.of_scene(scene)})
        return replace(plan, scene=refined_scene(plan.scene, self.refinements))

    def of_scene(self, scene: str) -> dict[str, float]:
        """Settings of the scene that are knobs; those that it does not have or leaves are missing.

        The mesh of a letter is always named: a scene may ship with a coarser one than usual.
        """
        from warp_softbody import scenes

        known = {setting.name for setting in scenes.recipe(scene).settings}
        own = {name: getattr(self, name) for name in SCENE_KNOBS}
        if not self.coarse and "coarse" not in known:
            del own["coarse"]
        return {name: value for name, value in own.items() if value is not None}

    def changes(self, other: Settings) -> int:
        """How many knobs are not as in the other."""
        return sum(getattr(self, knob) != getattr(other, knob) for knob in KNOBS)

    def differences(self, other: Settings) -> str:
        """What is not as in the other, for people; "default" where nothing is."""
        changed = [
            f"{NAMES.get(knob, knob)} {shown(knob, getattr(self, knob))}".strip()
            for knob in KNOBS
            if getattr(self, knob) != getattr(other, knob)
        ]
        return ", ".join(changed) or "default"


SCENE_KNOBS = ("cells", "patches", "coarse")
"""Knobs that are settings of the scene."""

KNOBS = tuple(field.name for field in fields(Settings))
OPTIONS: dict[str, Option] = {
    one.knob: one
    for one in (*options_of(SimulationOptions), *options_of(ControlOptions))
    if one.knob is not None
}
"""Options that are knobs, by the names of these."""

NAMES = {knob: one.short for knob, one in OPTIONS.items() if one.short is not None}
"""Shorter ones of knobs; none where the value speaks for itself."""


def as_option(value: Any) -> Any:
    """A knob's value as its option takes it: charts write "two-level" with a hyphen."""
    return value.replace("-", "_") if isinstance(value, str) else value


def shown(knob: str, value: Any) -> str:
    """A knob's value for people: time steps as fractions of a second."""
    if value is None:
        return "as shipped"
    if knob == "level" and value < 0:
        return f"{value} (coarser)"
    if knob == "time_step":
        fraction = Fraction(value).limit_denominator(100_000)
        return f"{fraction} s" if fraction.numerator == 1 else f"{value:.4g} s"
    return f"{value:g}" if isinstance(value, float) else str(value)
