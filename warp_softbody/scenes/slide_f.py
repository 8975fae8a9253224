"""Letter F is pulled over a slippery floor and leans against the pull (the paper's sliding F)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.characters import letter_f
from warp_softbody.characters.fibers import QUADRANTS
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.slide import Slide, SlideGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Setting, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.world.ground import Plane
from warp_softbody.world.scene import STANDARD_GRAVITY, Push, Scene

GAINS = SlideGains(
    tilt=14.27,  # g/L
    spin=6.386,  # sqrt(g/L)
    learning=6.509,  # (g/L)^(3/2)
    lean=0.6,
    furthest=0.12,  # L
    spin_weight=30.0,  # of rows in m g L dt
    activation=ActivationCost(effort=0.4, change=0.75),
)
"""By hand, in some sixty runs: on another mesh, with friction and stiffness 20 % up or down, half
the step, a pull of 0.3 body weights and pushes. A plan for the momentum too chatters even at rest
(22 % of the accelerations turn): a floor with a friction of 0.1 cannot give what it asks. With half
the cost of a change 12 % turn on the refined mesh, pulled to the left."""

PULL_START = 0.5  # s
PULL_GROWS = 2.5  # s
PULL_FADES = 0.5  # s
PULL_PIECE = 0.05  # s, of constant force
DELAYED_START = 2.505  # sqrt(L/g): 0.3 s after the pull begins

RIM = tuple(f"rim_{i}" for i in range(4))


def sliding_letter(coarse: float = 0.0) -> Character:
    """Letter F with regions for the left and right edges of its foot, each in two halves.

    A patch acts at the mean of its nodes; on quadrants of the foot the plan would know only half of
    the torque that the foot can bear.
    """
    letter = letter_f(coarse=int(coarse))
    base = letter.region("base")
    x, y, _ = letter.mesh.points[base].T
    edge = np.abs(x) > np.abs(x).max() - 1e-6
    rim = {
        name: base[edge & (side_x * x > 0.0) & (side_y * y > -1e-6)]
        for name, (side_x, side_y) in zip(RIM, QUADRANTS, strict=True)
    }
    return replace(letter, regions={**letter.regions, **rim})


def growing_pull(character: Character, strongest: float) -> tuple[Push, ...]:
    """A pull at the head along x that grows evenly to so many body weights, then fades."""
    weight = character.material.density * character.mesh.volume * STANDARD_GRAVITY
    known = np.array([0.0, PULL_GROWS, PULL_GROWS + PULL_FADES])
    starts = np.arange(round(known[-1] / PULL_PIECE)) * PULL_PIECE
    sizes = np.interp(starts + 0.5 * PULL_PIECE, known, [0.0, strongest * weight, 0.0])
    return tuple(
        Push(
            region="head",
            force=(float(size), 0.0, 0.0),
            start=PULL_START + float(start),
            duration=PULL_PIECE,
        )
        for start, size in zip(starts, sizes, strict=True)
        if size
    )


def _build(values: Values, side: float, start: float) -> tuple[Scene, Slide]:
    character = sliding_letter(values["coarse"])
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=growing_pull(character, side * values["pull"]) + head_push(character, values),
    )
    return scene, Slide(GAINS, start=start, patches=RIM)


def build(values: Values) -> tuple[Scene, Slide]:
    """Pulled along +x."""
    return _build(values, 1.0, 0.0)


def build_left(values: Values) -> tuple[Scene, Slide]:
    """Pulled along -x."""
    return _build(values, -1.0, 0.0)


def build_delayed(values: Values) -> tuple[Scene, Slide]:
    """Pulled along +x, limp until the pull has acted for a while."""
    return _build(values, 1.0, DELAYED_START)


PULL = Setting(
    name="pull",
    default=0.27,
    low=0.0,
    high=2.0,
    unit="body weights",
    help="strongest pull at the head, 3 s after the start",
)
SETTINGS = (
    PULL,
    replace(PUSH_SETTINGS[0], default=0.0),
    PUSH_SETTINGS[1],
    replace(PUSH_SETTINGS[2], default=0.1),
)

SLIDE_F = SceneRecipe(
    name="slide-f",
    description="letter F is pulled to the right over a slippery floor and leans against it",
    settings=(*SETTINGS, coarse_setting("letter_f")),
    build=build,
    seconds=7.0,
    time_step=1.0 / 60.0,
)

SLIDE_F_LEFT = replace(
    SLIDE_F,
    name="slide-f-left",
    description="letter F is pulled to the left over a slippery floor and leans against it",
    settings=(*SETTINGS, coarse_setting("letter_f", shipped=2)),
    build=build_left,
)

SLIDE_F_DELAYED = replace(
    SLIDE_F,
    name="slide-f-delayed",
    description="letter F is pulled to the right, limp for the first 0.3 s of the pull",
    build=build_delayed,
)
