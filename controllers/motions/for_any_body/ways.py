"""How a body may go: what it moves in turn, and in which order, by its regions and shape."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.controllers.motions.any_body import LEAST_FEET, require_muscles, require_regions
from warp_softbody.controllers.motions.body_measures import BASE_PATCHES
from warp_softbody.controllers.motions.for_any_body.step_gains import (
    LYING,
    LYING_ON_LIMBS,
    ON_FEET,
    ON_ONE_SOLE,
    ON_THREE_FEET,
    StepGains,
)
from warp_softbody.controllers.motions.for_any_body.stepping import Stepping
from warp_softbody.controllers.motions.steering import Guide, checked_guide
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.world.scene import STANDARD_GRAVITY

Nodes = npt.NDArray[np.int32]
Turns = tuple[tuple[int, ...], ...]

LOW = 0.5
"""Height over length of a body below which it lies."""

BELLY = 0.35
"""Height, over the body's, up to which its skin is its belly."""

SECTIONS = 5
"""Parts of a belly, one behind the other: one is pushed along while the others hold."""

LEAST_LENGTH = 2.0
"""Length along the heading, over the height, of a body that crawls."""


MOST_STRIDE = 1.5
"""Times the stride of the gains that may be asked for by a speed."""

MOST_CRAWLED = 1.0
"""The same of a crawl. Asked for 1.5 times as much, five of six bodies that lie crawled by 0.6 to
0.8 of it: each section is pushed along from where the last one left it, and reaches no further."""


class Way(NamedTuple):
    """What a body goes on.

    Attributes:
        feet: nodes of each, of the skin.
        turns: which feet are moved together, one entry after the other.
        gains: that suit it.
    """

    feet: tuple[Nodes, ...]
    turns: Turns
    gains: StepGains


def way_to_walk(character: Character) -> Way:
    """Three feet or more, each pair across from each other in turn, else the parts of a sole.

    Raises:
        InputError: the body has no muscles, or neither feet nor the quadrants of a base.
    """
    require_regions("Walk", character, ("base",))
    require_muscles("Walk", character)
    names = [name for name in character.regions if name.startswith("foot_")]
    feet = tuple(character.region(name) for name in names if len(character.region(name)))
    if len(feet) >= LEAST_FEET:
        gains = ON_FEET if len(feet) > LEAST_FEET else ON_THREE_FEET
        return Way(feet, _across(character, feet), LYING_ON_LIMBS if lies(character) else gains)
    require_regions("Walk on fewer than three feet", character, BASE_PATCHES)
    quadrants = tuple(character.region(name) for name in BASE_PATCHES)
    # around the sole, so that its lifted corner wanders around it
    return Way(quadrants, ((2,), (3,), (0,), (1,)), ON_ONE_SOLE)


def way_to_crawl(character: Character, heading: float) -> Way:
    """Sections of the belly along the heading, from the last to the first.

    Raises:
        InputError: the body has no muscles, does not lie, or is short along the heading.
    """
    require_muscles("Crawl", character)
    if not lies(character):
        raise InputError(
            f"Crawl needs a body that lies, at most {LOW:g} times as high as long, and character "
            f"{character.name!r} stands"
        )
    points, skin = character.mesh.points, character.mesh.surface_nodes
    height = float(np.ptp(points[:, 2]))
    along = points[:, :2] @ np.array([np.cos(heading), np.sin(heading)])
    length = float(np.ptp(along))
    if length < LEAST_LENGTH * height:
        raise InputError(
            f"Crawl needs a body that is {LEAST_LENGTH:g} times as long along its heading as high, "
            f"and character {character.name!r} is {length:.3g} m long along {heading:.3g} rad and "
            f"{height:.3g} m high"
        )
    belly = skin[points[skin, 2] - points[:, 2].min() < BELLY * height]
    section = np.floor(SECTIONS * (along[belly] - along.min()) / length)
    section = np.clip(section, 0, SECTIONS - 1)
    parts = [belly[section == k].astype(np.int32) for k in range(SECTIONS)]
    feet = tuple(part for part in parts if len(part))
    return Way(feet, tuple((k,) for k in range(len(feet))), LYING)


def stepping(
    motion: str,
    character: Character,
    way: Way,
    heading: float,
    speed: float | None,
    gains: StepGains | None,
    steering: Guide | None,
    most: float = MOST_STRIDE,
) -> Stepping:
    """The controller that goes a way along a heading, rad, at a speed, m/s, or as it is steered.

    Raises:
        InputError: the speed takes longer strides than ``most`` times those of the gains.
    """
    heading = checks.number(f"heading of {motion}", heading, unit="rad")
    gains = way.gains if gains is None else checks.instance(f"gains of {motion}", gains, StepGains)
    if steering is not None:
        steering = checked_guide(f"steering of {motion}", steering)
        if speed is not None:
            raise InputError(
                f"{motion} takes a speed or a steering, not both; the steering has the speed in it"
            )
    most_stride = most * gains.stride
    if speed is not None:
        length = float(np.ptp(character.mesh.bounds, axis=0).max())
        cycle = len(way.turns) * gains.step * float(np.sqrt(length / STANDARD_GRAVITY))
        fastest = most_stride * length / cycle
        speed = checks.number(f"speed of {motion}", speed, low=0.0, high=fastest, unit="m/s")
        gains = replace(gains, stride=speed * cycle / length)
    return Stepping(
        gains,
        feet=way.feet,
        turns=way.turns,
        heading=heading,
        steering=steering,
        most_stride=most_stride,
    )


def lies(character: Character) -> bool:
    """Whether a body is much longer than high."""
    x, y, height = np.ptp(character.mesh.bounds, axis=0)
    return bool(height < LOW * max(x, y))


def _across(character: Character, feet: tuple[Nodes, ...]) -> Turns:
    """Every other foot around the body's middle together; of three feet one after the other."""
    places = np.array([character.mesh.points[own, :2].mean(axis=0) for own in feet])
    order = _around(places)
    if len(order) < 4:
        return tuple((foot,) for foot in order)
    even = len(order) // 2 * 2
    turns = [tuple(order[0:even:2]), tuple(order[1:even:2])]
    return (*turns, *((foot,) for foot in order[even:]))


def _around(places: FloatArray) -> list[int]:
    """Numbers of places (f, 2) in order around their mean."""
    ways = places - places.mean(axis=0)
    # rounded, so that mirror images keep their order
    angles = np.round(np.arctan2(ways[:, 1], ways[:, 0]), 6)
    return [int(number) for number in np.argsort(angles, kind="stable")]
