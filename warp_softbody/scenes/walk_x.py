"""Letter X walks, one foot or two at a time (the paper's walking X)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.characters import letter_x
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.steering import Trail
from warp_softbody.controllers.motions.walk import DIAGONAL_PAIRS, ONE_BY_ONE, Gait, Walk
from warp_softbody.controllers.motions.walk_gains import WalkGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.scenes.uneven_ground import GROUND_SETTINGS, ground_ahead, is_uneven
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import Scene

STIFFNESS = 9e5
"""Pa: at 0.5 MPa the middle comes down to 0.06 m above the ground while two limbs carry it, and the
total volume changes by 6 %."""

POISSON_RATIO = 0.475
"""With 0.45 the volume changes by 3 to 4 % while two limbs carry the body, with this by 2 %."""

STRENGTH = 1.111  # E, to bend limbs that are as stiff as this

SLOW = WalkGains(
    stride=0.34,  # L
    swing=1.409,  # sqrt(L/g)
    lift=0.045,  # L
    sway=0.26,  # of the distance from the feet
    position=6.116,  # g/L
    velocity=3.831,  # sqrt(g/L)
    spin=1.916,  # sqrt(g/L)
    learning=0.6,  # sqrt(L/g)
    momentum_weight=0.005,  # of rows in m g dt
    spin_weight=0.06,  # of rows in m g L dt
    foot_position=3.193,  # sqrt(g/L)
    foot_velocity=9.578,  # sqrt(g/L)
    foot_weight=0.001,  # of rows in g dt
    activation=ActivationCost(effort=0.08, change=0.09396),
)
"""By hand, near the best of 97 random draws of both gaits by the share of node accelerations that
change sign; checked with friction, strength and stiffness 20 % up and down and half the time step.
The weights are small beside the costs of activation, as walking smoothly needs. Without learning
the middle comes down to 0.04 m at half the step; with half the weight of momentum it sinks to the
ground at a quarter of it, or with two iterations at half."""

FAST = replace(
    SLOW,
    swing=2.004,  # sqrt(L/g)
    position=9.174,  # g/L
    turn=15.0,  # g/L
    spin=4.0,  # sqrt(g/L)
    foot_position=5.0,  # sqrt(g/L)
    foot_velocity=5.5,  # sqrt(g/L)
)
"""Two feet let the body tip over the line between them. Without a turn it keeps what it has tipped:
in 11 s at half the step two feet then come 21 mm high and two 93, at a quarter it goes half as far;
now 35 and 76, and as far. With a foot velocity of 6 a tenth of the accelerations change sign at
twice the step, with a foot weight of 0.002 at half of it feet hardly leave the ground."""

STEERED = replace(
    FAST,
    momentum_weight=0.025,
    foot_velocity=4.5,
    activation=ActivationCost(effort=0.06, change=0.115),
)
"""It keeps its height by a larger weight while it turns, and so shakes more: 6 to 7 % instead of 5
of the accelerations change sign. So the feet are softer, and a change costs more: with the cost of
`FAST` a tenth of them do at twice the step."""

UNEVEN = replace(SLOW, sway=0.15, momentum_weight=0.01)
"""Up a slope of 15 degrees the body of the level gains sinks between limbs that its sway has taken
apart; with these it goes on as fast as on level ground."""

FRICTION = PUSH_SETTINGS[-1]
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
PUSH_SECONDS = PUSH_SETTINGS[1]
SETTINGS = (PUSH, PUSH_SECONDS, FRICTION, coarse_setting("letter_x"))


def walking_letter(coarse: float = 0.0) -> Character:
    """Letter X of a stiffer material whose volume hardly changes, with stronger muscles."""
    letter = letter_x(coarse=int(coarse))
    changes = {"young_modulus": STIFFNESS, "poisson_ratio": POISSON_RATIO}
    return replace(
        letter,
        material=replace(letter.material, **changes, volume="exact"),
        muscles=tuple(replace(group, strength=STRENGTH * STIFFNESS) for group in letter.muscles),
    )


def _build(values: Values, gains: WalkGains, gait: Gait) -> tuple[Scene, Walk]:
    character = walking_letter(values["coarse"])
    scene = Scene(
        character=character,
        ground=ground_ahead(values),
        pushes=head_push(character, values),
    )
    return scene, Walk(gains, gait=gait)


def build_slow(values: Values) -> tuple[Scene, Walk]:
    """One foot at a time."""
    return _build(values, UNEVEN if is_uneven(values) else SLOW, ONE_BY_ONE)


def build_fast(values: Values) -> tuple[Scene, Walk]:
    """Two feet at a time, across from each other."""
    return _build(values, FAST, DIAGONAL_PAIRS)


SPEED = Setting(
    name="speed",
    default=0.24,
    low=0.05,
    high=0.25,
    unit="m/s",
    help="at which the plan goes along the figure of eight",
)
RADIUS = Setting(
    name="radius", default=0.6, low=0.6, high=10.0, unit="m", help="of both of its circles"
)
CIRCLE_POINTS = 96


def figure_of_eight(radius: float) -> FloatArray:
    """Points (k, 2) m of two circles that touch at the origin, the left one first."""
    angle = np.linspace(0.0, 2.0 * np.pi, CIRCLE_POINTS + 1)
    across, along = radius * np.sin(angle), radius * (1.0 - np.cos(angle))
    return np.column_stack([np.r_[across, across[1:]], np.r_[along, -along[1:]]])


def build_eight(values: Values) -> tuple[Scene, Walk]:
    """Two feet at a time, along a figure of eight."""
    character = walking_letter(values["coarse"])
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    trail = Trail(points=figure_of_eight(values["radius"]), forward=values["speed"])
    return scene, Walk(STEERED, gait=DIAGONAL_PAIRS, steering=trail)


WALK_X = SceneRecipe(
    name="walk-x",
    description="letter X walks, one foot at a time",
    settings=(*SETTINGS, *GROUND_SETTINGS),
    build=build_slow,
    seconds=7.5,
    time_step=1.0 / 60.0,
)

WALK_X_FAST = SceneRecipe(
    name="walk-x-fast",
    description="letter X walks faster, two feet at a time",
    settings=(*SETTINGS, *GROUND_SETTINGS),
    build=build_fast,
    seconds=5.5,
    time_step=1.0 / 60.0,
)

WALK_X_EIGHT = SceneRecipe(
    name="walk-x-eight",
    description="letter X walks along a figure of eight",
    settings=(SPEED, RADIUS, *SETTINGS),
    build=build_eight,
    seconds=34.0,
    time_step=1.0 / 60.0,
)
