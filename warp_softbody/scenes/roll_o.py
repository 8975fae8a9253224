"""Letter O rolls, and rolls back (the paper's rolling O)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_o
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.roll import Roll
from warp_softbody.controllers.motions.roll_gains import Leg, RollGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 2.6  # E
STIFFNESS_DAMPING = 0.09  # s

GAINS = RollGains(
    cruise=0.415,  # sqrt(g/L)
    speedup=0.0815,  # g/L
    brake=0.056,  # g/L
    closing=1.1,  # sqrt(g/L)
    follow=0.96,  # sqrt(g/L)
    acceleration=0.102,  # g/L
    tilt_gain=2.0,
    shape_follow=2.55,  # sqrt(g/L)
    roll_weight=2.0,  # of a row in m g L dt
    steady_weight=0.03,  # of rows in m g dt and m g L dt
    tilt_weight=0.08,  # sqrt(L/g)
    squash_weight=0.1,  # sqrt(L/g)
    activation=ActivationCost(effort=0.8, change=1.5),
)
"""By hand. Cruise, speedup and brake are within reach of the body however its motion is computed,
so that it stops where it is to (`python -m benchmarks.fidelity --scenes roll-o roll-o-return`)."""

AWAY = (Leg(direction=1.0, turn=np.radians(390.0)),)
RETURN = tuple(Leg(direction=way, turn=np.radians(220.0)) for way in (1.0, -1.0))
FRICTION = PUSH_SETTINGS[-1]
PATCHES = Setting(
    name="patches", whole=True, default=6, low=4, high=8, help="contacts that the plan knows"
)
SETTINGS = (FRICTION, PATCHES, coarse_setting("letter_o", shipped=1))


def rolling_letter(coarse: float = 0.0) -> Character:
    """Letter O with stronger muscles, more damping and a volume that hardly changes."""
    letter = letter_o(coarse=int(coarse))
    strength = STRENGTH * letter.material.young_modulus
    muscles = tuple(replace(group, strength=strength) for group in letter.muscles)
    material = replace(letter.material, volume="exact", stiffness_damping=STIFFNESS_DAMPING)
    return replace(letter, material=material, muscles=muscles)


def _build(values: Values, legs: tuple[Leg, ...]) -> tuple[Scene, Roll]:
    character = rolling_letter(values["coarse"])
    scene = Scene(character=character, ground=Plane(friction=values["friction"]))
    return scene, Roll(GAINS, legs=legs, rim="rim", patches=int(values["patches"]))


def build(values: Values) -> tuple[Scene, Roll]:
    """Roll along +x by an angle, stop, and go limp."""
    return _build(values, AWAY)


def build_return(values: Values) -> tuple[Scene, Roll]:
    """Roll along +x by an angle, stop, roll back, stop, and go limp."""
    return _build(values, RETURN)


ROLL_O = SceneRecipe(
    name="roll-o",
    description="letter O rolls right by 390 degrees and stops",
    settings=SETTINGS,
    build=build,
    seconds=10.0,
    time_step=1.0 / 60.0,
)

ROLL_O_RETURN = SceneRecipe(
    name="roll-o-return",
    description="letter O rolls right by 220 degrees, stops and rolls back",
    settings=SETTINGS,
    build=build_return,
    seconds=14.0,
    time_step=1.0 / 60.0,
)
