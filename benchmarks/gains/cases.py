"""What is searched for in each scene: gains and their ranges, and what is asked beyond criteria."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from warp_softbody import scenes
from warp_softbody.body.character import Character
from warp_softbody.controllers.controller import Controller
from warp_softbody.controllers.motions.balance import Balance
from warp_softbody.controllers.motions.roll import Roll
from warp_softbody.scenes import ScenePlan, balance_i, jump_i, jump_t, roll_o
from warp_softbody.teaching.ranges import Range

Changes = Mapping[str, float]


FAMILY = (
    "as shipped",
    "dt x 2",
    "dt / 2",
    "two iterations",
    "linear elements",
    "coarser mesh",
)
"""Cheap members that together say whether a motion belongs to its body or to one discretisation."""


BOUNDS = {"volume": 0.03, "reversals": 0.10}
"""Stricter bounds of criteria than those of `benchmarks.motions.criteria`, by their names."""


@dataclass(frozen=True, kw_only=True)
class GainCase:
    """One scene's search.

    Attributes:
        scene: name.
        gains: shipped ones, a dataclass.
        controller: made of gains.
        ranges: by the path of a gain in the dataclass; ``material.NAME`` stands for the
            character's, ``strength`` for that of all its muscles, in E.
        settings: of the scene.
        bounds: of criteria, in place of those that every motion has.
        stands: whether a run is over when the body falls.
        family: members by which each candidate is judged (`benchmarks.gains.family`).
    """

    scene: str
    gains: Any
    controller: Callable[[Any], Controller]
    ranges: Mapping[str, Range]
    settings: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, float] = field(default_factory=lambda: BOUNDS)
    stands: bool = True
    family: tuple[str, ...] = FAMILY

    def plan(self, changes: Changes, settings: Mapping[str, float]) -> ScenePlan:
        """The scene and its controller with some gains changed."""
        plan = scenes.make(self.scene, {**self.settings, **settings})
        gains, character = self.gains, plan.scene.character
        for name, value in changes.items():
            if name == "strength" or name.startswith("material."):
                character = changed_character(character, name, value)
            else:
                gains = changed(gains, name.split("."), value)
        scene = replace(plan.scene, character=character)
        return replace(plan, scene=scene, controller=self.controller(gains))

    def shipped(self) -> dict[str, float]:
        """The present values of the gains that have ranges."""
        scene = scenes.make(self.scene, self.settings).scene
        return {name: _value(self.gains, scene.character, name) for name in self.ranges}


def changed(values: Any, path: list[str], value: float) -> Any:
    """A dataclass, or a tuple, with the number at a path changed."""
    name, *rest = path
    if isinstance(values, tuple):
        index = int(name)
        return (*values[:index], value, *values[index + 1 :])
    inner = changed(getattr(values, name), rest, value) if rest else value
    return replace(values, **{name: inner})


def changed_character(character: Character, name: str, value: float) -> Character:
    """A character with a number of its material, or the strength of all muscles, changed."""
    if name == "strength":
        strength = value * character.material.young_modulus
        muscles = tuple(replace(group, strength=strength) for group in character.muscles)
        return replace(character, muscles=muscles)
    material = changed(character.material, name.split(".")[1:], value)
    return replace(character, material=material)


def _value(gains: Any, character: Character, name: str) -> float:
    if name == "strength":
        return character.muscles[0].strength / character.material.young_modulus
    values: Any = character if name.startswith("material.") else gains
    for part in name.split("."):
        values = values[int(part)] if isinstance(values, tuple) else getattr(values, part)
    return float(values)


BALANCE = {
    "position": Range(0.5, 5.0, log=True),
    "velocity": Range(1.0, 5.0, log=True),
    "spin": Range(0.5, 8.0, log=True),
    "upright": Range(0.5, 8.0, log=True),
    "upright_weight": Range(0.02, 3.0, log=True),
    "follow": Range(0.0, 0.8),
    "lean": Range(-0.3, 0.5),
    "height_weight": Range(0.05, 5.0, log=True),
    "squat": Range(0.5, 6.0, log=True),
    "least_height": Range(0.6, 0.9),
    "skip_from": Range(0.15, 0.3),
    "crouch": Range(0.0, 1.0),
    "momentum_weight": Range(0.002, 1.0, log=True),
    "spin_weight": Range(0.001, 5.0, log=True),
    "base_weight": Range(0.001, 0.6, log=True),
    "base_rate": Range(0.65, 1.9),
    "activation.effort": Range(0.005, 1.0, log=True),
    "activation.change": Range(0.003, 0.1, log=True),
    "strength": Range(0.4, 4.0, log=True),
    "material.young_modulus": Range(5e5, 2.5e6, log=True),
    "material.stiffness_damping": Range(0.02, 0.08, log=True),
}
JUMP = {
    "depth": Range(0.12, 0.22),
    "crouch_time": Range(1.3, 3.1),
    "launch.2": Range(0.34, 0.5),
    "rise": Range(0.3, 0.6),
    "push": Range(5.0, 12.5, log=True),
    "push_spin": Range(3.0, 12.5, log=True),
    "momentum_weight": Range(0.2, 3.0, log=True),
    "spin_weight": Range(1.0, 30.0, log=True),
    "height": Range(0.4, 0.48),
    "reach_rate": Range(2.5, 6.0, log=True),
    "reach_weight": Range(5.0, 100.0, log=True),
    "activation.effort": Range(0.01, 0.1, log=True),
    "activation.change": Range(0.01, 0.25, log=True),
    "landing.momentum_weight": Range(0.02, 0.3, log=True),
    "landing.spin_weight": Range(0.5, 12.0, log=True),
    "landing.velocity": Range(1.6, 4.5, log=True),
    "landing.position": Range(2.0, 5.1, log=True),
    "landing.crouch": Range(0.0, 1.0),
    "landing.activation.change": Range(0.03, 0.8, log=True),
    "ease": Range(0.0, 6.0),
    "strength": Range(2.0, 6.0, log=True),
    "material.poisson_ratio": Range(0.465, 0.485),
    "material.stiffness_damping": Range(0.015, 0.04, log=True),
}
FORWARD = {"launch.0": Range(0.04, 0.14), "way.0": Range(0.07, 0.13), "play": Range(0.03, 0.1)}
TURN = {"turn": Range(0.9, 1.6), "wind": Range(-1.3, -0.5)}
ROLL = {
    "cruise": Range(0.3, 0.5),
    "speedup": Range(0.05, 0.12),
    "brake": Range(0.04, 0.08),
    "closing": Range(0.6, 1.6),
    "follow": Range(0.5, 1.6),
    "tilt_gain": Range(0.5, 3.0),
    "shape_follow": Range(1.0, 4.0),
    "roll_weight": Range(0.5, 5.0, log=True),
    "tilt_weight": Range(0.02, 0.3, log=True),
    "squash_weight": Range(0.02, 0.4, log=True),
    "activation.effort": Range(0.2, 2.0, log=True),
    "activation.change": Range(0.3, 4.0, log=True),
    "strength": Range(1.4, 2.7, log=True),
    "material.stiffness_damping": Range(0.03, 0.1, log=True),
}

CASES = {
    case.scene: case
    for case in (
        GainCase(
            scene="balance-i",
            gains=balance_i.GAINS,
            controller=Balance,
            ranges=BALANCE,
            family=(*FAMILY, "push=0.45", "dt / 4", "side=180", "push=0.3 + side=90"),
        ),
        GainCase(
            scene="jump-i",
            gains=jump_i.FORWARD,
            controller=lambda gains: jump_i.jumper(gains, jumps=jump_i.HOPS),
            ranges=JUMP | FORWARD,
        ),
        GainCase(
            scene="jump-i-in-place",
            gains=jump_i.IN_PLACE,
            controller=lambda gains: jump_i.jumper(gains, jumps=3),
            ranges=JUMP,
        ),
        GainCase(
            scene="jump-t",
            gains=jump_t.TWIST,
            controller=jump_t.jumper,
            ranges=JUMP | TURN,
        ),
        GainCase(
            scene="roll-o",
            gains=roll_o.GAINS,
            controller=lambda gains: Roll(gains, legs=roll_o.AWAY, rim="rim"),
            ranges=ROLL,
            stands=False,
        ),
        GainCase(
            scene="roll-o-return",
            gains=roll_o.GAINS,
            controller=lambda gains: Roll(gains, legs=roll_o.RETURN, rim="rim"),
            ranges=ROLL,
            stands=False,
        ),
    )
}
