"""Letter H sways from side to side (the paper's exercising H)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_h
from warp_softbody.controllers.body_units import BodyUnits, in_si
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.exercise import Exercise, ExerciseGains, Sway
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STRENGTH = 1.0
"""E: a quarter more than the letter has, so that muscles a fifth weaker still reach the path."""

POISSON_RATIO = 0.47
"""The volume changes by 2.4 %, with linear elements by 2.6 %; with 0.46 by up to 3.1 %."""

PATH = Sway(amplitude=0.09, period=6.264, periods=4.0, ease=1.566)  # L, sqrt(L/g)

START = 1.566  # sqrt(L/g)

GAINS = ExerciseGains(
    position=40.79,  # g/L
    velocity=12.77,  # sqrt(g/L)
    spin=6.5,  # sqrt(g/L)
    learning=0.157,  # sqrt(L/g)
    momentum_weight=1.0,  # of rows in m g dt
    spin_weight=4.5,  # of rows in m g L dt
    activation=ActivationCost(effort=0.5, change=0.25),
)
"""By hand, in some forty runs at the shipped step, twice and half of it, with two and three Newton
iterations: Kp and learning until the path is met, less spin weight and more effort until fewer than
a tenth of the accelerations turn at 1/30 s (9.6 %; 10.4 % with a spin weight of 5); it falls with
three iterations below a spin of 4, at a quarter of the step with 5."""


def exercising_letter(coarse: float = 0.0) -> Character:
    """Letter H whose volume hardly changes, with stronger muscles."""
    letter = letter_h(coarse=int(coarse))
    strength = STRENGTH * letter.material.young_modulus
    muscles = tuple(replace(group, strength=strength) for group in letter.muscles)
    material = replace(letter.material, volume="exact", poisson_ratio=POISSON_RATIO)
    return replace(letter, material=material, muscles=muscles)


def build(values: Values) -> tuple[Scene, Exercise]:
    """The letter on a floor, and four periods of its exercise."""
    character = exercising_letter(values["coarse"])
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
    settings=(
        replace(PUSH_SETTINGS[0], default=0.0),
        *PUSH_SETTINGS[1:],
        coarse_setting("letter_h"),
    ),
    build=build,
    seconds=9.5,
    time_step=1.0 / 60.0,
)
