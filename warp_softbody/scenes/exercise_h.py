"""Letter H sways from side to side (the paper's exercising H)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_h
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.exercise import Exercise, ExerciseGains, Sway
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 1.0
"""E: a quarter more than the letter has, so that muscles a fifth weaker still reach the path."""

POISSON_RATIO = 0.46
"""A push of 0.2 body weights changes the volume by 4 %; with the letter's own 0.45 by 5 %, and by
6 % where the volume is not exact."""

PATH = Sway(amplitude=0.09, period=6.264, periods=4.0, ease=1.566)  # L, sqrt(L/g)

START = 1.566  # sqrt(L/g)

GAINS = ExerciseGains(
    position=20.39,  # g/L
    velocity=7.982,  # sqrt(g/L)
    spin=2.554,  # sqrt(g/L)
    momentum_weight=1.0,  # of rows in m g dt
    spin_weight=30.0,  # of rows in m g L dt
    activation=ActivationCost(effort=0.3, change=0.1253),
)
"""By hand, in some thirty runs: Kp until the path is met, then effort until a push of 0.2 body
weights and half the time step do no harm."""


def exercising_letter() -> Character:
    """Letter H whose volume hardly changes, with stronger muscles."""
    letter = letter_h()
    strength = STRENGTH * letter.material.young_modulus
    muscles = tuple(replace(group, strength=strength) for group in letter.muscles)
    material = replace(letter.material, volume="exact", poisson_ratio=POISSON_RATIO)
    return replace(letter, material=material, muscles=muscles)


def build(values: Values) -> tuple[Scene, Exercise]:
    """The letter on a floor, and four periods of its exercise."""
    character = exercising_letter()
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, Exercise(GAINS, path=PATH, start=START)


def path_in_si(scene: Scene) -> tuple[Sway, float]:
    """The path of the scene's centre of mass in m and s, and when it starts, s."""
    units = BodyUnits.of_scene(scene)
    return in_si(PATH, units), START * units.time


RECIPE = SceneRecipe(
    name="exercise-h",
    description="letter H sways from side to side",
    settings=(replace(PUSH_SETTINGS[0], default=0.0), *PUSH_SETTINGS[1:]),
    build=build,
    seconds=9.5,
    time_step=1.0 / 60.0,
)
