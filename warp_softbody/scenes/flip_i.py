"""Letter I turns a somersault and lands on its base."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_i
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.balance_gains import ANY_BODY
from warp_softbody.controllers.motions.flip import Flip
from warp_softbody.controllers.motions.flip_gains import FlipGains, TakeOff
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.jump_i import sole
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STIFFNESS = 4e6
"""Pa, eight times that of the letter that jumps. Let go at once, that one rises by 0.35 m; but on a
flat sole it gets hardly more angular momentum than 0.2 L times its momentum, and turns by less than
half a turn. What it turns by goes with the stiffness."""

STRENGTH = 4.0
"""E, as of the letter that jumps."""

POISSON_RATIO = 0.48
STIFFNESS_DAMPING = 0.007  # s

TAKE_OFF = TakeOff(
    crouch=2.037,  # sqrt(L/g)
    interval=0.0755,  # sqrt(L/g)
    levels=(
        (0.516, 0.512, 0.699, 0.508),
        (0.542, 0.703, 0.502, 0.502),
        (0.971, 0.991, 0.788, 0.937),
        (0.917, 0.902, 0.903, 0.854),
        (0.955, 0.835, 0.768, 0.840),
        (0.647, 0.794, 0.864, 0.907),
    ),
)
"""Found by cmaes on the coarsest mesh. The letter crouches bent back, throws its upper half
forward, and lets go behind a little before it does so ahead."""

GAINS = FlipGains(
    lean=1.075,  # rad
    landing_height=0.381,  # L
    open=0.169,  # sqrt(L/g)
    least_length=0.559,
    tuck_rate=6.55,  # sqrt(g/L)
    arrest_time=0.301,  # sqrt(L/g)
    upright=0.12,  # rad
    longest_arrest=4.7,  # sqrt(L/g)
    height=0.349,  # L
    position=4.59,  # g/L
    velocity=13.8,  # sqrt(g/L)
    righting_velocity=2.07,  # sqrt(g/L)
    turn=4.59,  # g/L
    spin=4.08,  # sqrt(g/L)
    momentum_weight=0.0367,  # of rows in m g dt
    spin_weight=22.3,  # of rows in m g L dt
    air=ActivationCost(effort=0.005, change=0.005),
    arrest=ActivationCost(effort=0.02, change=0.136),
    righting=ActivationCost(effort=0.1, change=0.5),
    landing=ANY_BODY,
)
"""Found by cmaes from a take-off on the coarsest mesh, but for righting and standing. With the
gains of the letter that jumps so stiff a letter stays crouched and sways. What a landing leaves of
the spin differs from run to run, so the letter is turned upright before it balances, slowly: with
the velocity gain of the landing it shakes."""

START = Setting(
    name="start", default=0.1, low=0.0, high=20.0, unit="sqrt(L/g)", help="when it begins to crouch"
)
FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
SETTINGS = (START, PUSH, PUSH_SETTINGS[1], FRICTION, coarse_setting("letter_i"))


def flipping_letter(coarse: float = 0.0) -> Character:
    """Letter I of a stiffer material, with stronger muscles and less damping."""
    letter = letter_i(coarse=int(coarse))
    return replace(
        letter,
        material=replace(
            letter.material,
            volume="exact",
            young_modulus=STIFFNESS,
            poisson_ratio=POISSON_RATIO,
            stiffness_damping=STIFFNESS_DAMPING,
        ),
        muscles=tuple(replace(group, strength=STRENGTH * STIFFNESS) for group in letter.muscles),
    )


def build(values: Values) -> tuple[Scene, Flip]:
    """One somersault, forward."""
    character = flipping_letter(values["coarse"])
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    return scene, Flip(GAINS, take_off=TAKE_OFF, start=values["start"], resting=sole(character))


RECIPE = SceneRecipe(
    name="flip-i",
    description="letter I turns a somersault and lands on its base",
    settings=SETTINGS,
    build=build,
    seconds=4.5,
    time_step=1.0 / 240.0,
)
