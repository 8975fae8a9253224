"""What one point of a chart is run with: mesh, time step and every option that costs time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from warp_softbody.engine.options import Cone, Elements, Precision, SimulationOptions, Tangent
from warp_softbody.errors import InputError

if TYPE_CHECKING:
    from warp_softbody.scenes import ScenePlan


@dataclass(frozen=True, kw_only=True)
class Settings:
    """A point's knobs.

    Attributes:
        time_step: s.
        cells: the scene's setting of that name; None for its default, or where it has none.
        level: how often every tet of that mesh is cut into eight.
        elements, tangent, precision, cone, newton_iterations, threads: as in `SimulationOptions`.
        tolerance: of the linear solve; None for the precision's own.
        method: how muscles are driven, "qpcc" or "static".
        qps: most QPs of a step; None for the driver's own.
        plan_cone: directions of the friction cones that a controller plans with; None for 8.
        patches: the scene's setting of that name; None for its default, or where it has none.
        preconditioner: "factor" or "two-level"; None for the one that suits the body's size.
    """

    time_step: float
    cells: int | None = None
    level: int = 0
    elements: Elements = "linear"
    tangent: Tangent = "warped"
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
    def possible(self) -> bool:
        """Whether the engine has this combination."""
        return self.elements == "linear" or self.tangent == "warped"

    def options(self) -> SimulationOptions:
        """Those of the engine."""
        return SimulationOptions(
            time_step=self.time_step,
            precision=self.precision,
            tangent=self.tangent,
            elements=self.elements,
            cone=self.cone,
            newton_iterations=self.newton_iterations,
            threads=self.threads,
            tolerance=self.tolerance,
        )

    def plan(self, scene: str, given: Mapping[str, str | float]) -> ScenePlan:
        """The scene on this mesh; ``given`` are its other settings."""
        from warp_softbody import scenes
        from warp_softbody.world.refined_scene import refined_scene

        own = {"cells": self.cells, "patches": self.patches}
        chosen = {name: value for name, value in own.items() if value is not None}
        plan = scenes.make(scene, {**given, **chosen})
        return replace(plan, scene=refined_scene(plan.scene, self.level))

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


KNOBS = tuple(field.name for field in fields(Settings))
NAMES = {
    "time_step": "dt",
    "newton_iterations": "Newton",
    "method": "",
    "precision": "",
    "elements": "",
    "qps": "QPs",
    "plan_cone": "planned cone",
    "preconditioner": "",
}
"""Shorter ones, where the value does not speak for itself."""


def shown(knob: str, value: Any) -> str:
    """A knob's value for people: time steps as fractions of a second."""
    if value is None:
        return "as shipped"
    if knob == "time_step":
        fraction = Fraction(value).limit_denominator(100_000)
        return f"{fraction} s" if fraction.numerator == 1 else f"{value:.4g} s"
    return f"{value:g}" if isinstance(value, float) else str(value)
