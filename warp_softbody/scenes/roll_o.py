"""Letter O rolls, and rolls back (the paper's rolling O)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.character import Character
from warp_softbody.characters import letter_o
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.roll import Leg, Roll, RollGains
from warp_softbody.ground import Plane
from warp_softbody.scene import Scene
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS

STRENGTH = 1.3e6  # Pa
STIFFNESS_DAMPING = 0.073  # s

GAINS = RollGains(
    lead=0.14,  # m
    position=27.0,  # 1/s^2
    velocity=1.0,  # 1/s
    spin=0.29,  # m g times 1 m
    top_speed=1.8,  # m/s
    follow=0.083,  # s
    spin_weight=0.02,  # of rows in m g dt times 1 m
    momentum_weight=0.027,  # of rows in m g dt
    activation=ActivationCost(effort=0.031, change=5.2),
)

AWAY = (Leg(2.5, 1.0),)
RETURN = (Leg(1.8, 1.0), Leg(1.5, 0.0), Leg(2.5, -1.0))
FRICTION = PUSH_SETTINGS[-1]


def rolling_letter() -> Character:
    """Letter O with stronger muscles, more damping and a volume that hardly changes."""
    letter = letter_o()
    muscles = tuple(replace(group, strength=STRENGTH) for group in letter.muscles)
    material = replace(letter.material, volume="exact", stiffness_damping=STIFFNESS_DAMPING)
    return replace(letter, material=material, muscles=muscles)


def _build(values: Values, legs: tuple[Leg, ...]) -> tuple[Scene, Roll]:
    scene = Scene(character=rolling_letter(), ground=Plane(friction=values["friction"]))
    return scene, Roll(GAINS, legs=legs, rim="rim")


def build(values: Values) -> tuple[Scene, Roll]:
    """Roll along +x for 2.5 s, then limp."""
    return _build(values, AWAY)


def build_return(values: Values) -> tuple[Scene, Roll]:
    """Roll along +x, stop, roll back, then limp."""
    return _build(values, RETURN)


ROLL_O = SceneRecipe(
    name="roll-o",
    description="letter O rolls to the right, then limp",
    settings=(FRICTION,),
    build=build,
    seconds=8.0,
    time_step=1.0 / 60.0,
)

ROLL_O_RETURN = SceneRecipe(
    name="roll-o-return",
    description="letter O rolls right, stops and rolls back left",
    settings=(FRICTION,),
    build=build_return,
    seconds=8.0,
    time_step=1.0 / 60.0,
)
