"""Letter O rolls, and rolls back (the paper's rolling O)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_o
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.roll import Leg, Roll, RollGains
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 2.6  # E
STIFFNESS_DAMPING = 0.09  # s, which brings it to rest in 5 s

GAINS = RollGains(
    lead=0.14,  # L
    position=2.752,  # g/L
    velocity=0.3193,  # sqrt(g/L)
    spin=0.29,  # m g L
    top_speed=0.5747,  # sqrt(g L)
    follow=0.26,  # sqrt(L/g)
    spin_weight=0.02,  # of rows in m g L dt
    momentum_weight=0.027,  # of rows in m g dt
    activation=ActivationCost(effort=0.031, change=0.1629),
)
"""Near the second best of 60 random draws of roll-o (benchmarks/gains/command.py, seed 1), kept
because it rolls with friction, stiffness and strength 20 % up and down, half the time step and
other meshes."""

AWAY = (Leg(direction=1.0, turn=np.radians(260.0)),)
RETURN = tuple(Leg(direction=way, turn=np.radians(110.0)) for way in (1.0, -1.0))
FRICTION = PUSH_SETTINGS[-1]
PATCHES = Setting(
    name="patches", whole=True, default=6, low=4, high=8, help="contacts that the plan knows"
)


def rolling_letter() -> Character:
    """Letter O with stronger muscles, more damping and a volume that hardly changes."""
    letter = letter_o()
    strength = STRENGTH * letter.material.young_modulus
    muscles = tuple(replace(group, strength=strength) for group in letter.muscles)
    material = replace(letter.material, volume="exact", stiffness_damping=STIFFNESS_DAMPING)
    return replace(letter, material=material, muscles=muscles)


def _build(values: Values, legs: tuple[Leg, ...]) -> tuple[Scene, Roll]:
    scene = Scene(character=rolling_letter(), ground=Plane(friction=values["friction"]))
    return scene, Roll(GAINS, legs=legs, rim="rim", patches=int(values["patches"]))


def build(values: Values) -> tuple[Scene, Roll]:
    """Roll along +x, then limp."""
    return _build(values, AWAY)


def build_return(values: Values) -> tuple[Scene, Roll]:
    """Roll along +x, limp until it stops, roll back, then limp."""
    return _build(values, RETURN)


ROLL_O = SceneRecipe(
    name="roll-o",
    description="letter O rolls to the right, then limp",
    settings=(FRICTION, PATCHES),
    build=build,
    seconds=10.0,
    time_step=1.0 / 60.0,
)

ROLL_O_RETURN = SceneRecipe(
    name="roll-o-return",
    description="letter O rolls right, stops and rolls back left",
    settings=(FRICTION, PATCHES),
    build=build_return,
    seconds=14.0,
    time_step=1.0 / 60.0,
)
