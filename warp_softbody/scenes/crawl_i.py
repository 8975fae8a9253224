"""The flat letter I crawls, as an earthworm and as an inchworm (the paper's crawling I)."""

from __future__ import annotations

from dataclasses import replace

from warp_softbody.character import Character
from warp_softbody.characters import letter_i_flat
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.crawl import Crawl, CrawlGains
from warp_softbody.ground import Plane
from warp_softbody.ground_friction import DirectionalFriction
from warp_softbody.scene import Scene
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push

EARTHWORM = CrawlGains(
    stride=0.145,  # m
    activation=ActivationCost(effort=1.0, change=40.0),
)
INCHWORM = CrawlGains(
    stride=0.32,  # m, what an arch of this height takes off the length
    arch=0.27,  # m, more than it reaches
    ground_weight=0.0,  # the ends stand on their edges
    middle_weight=0.4,
    activation=ActivationCost(effort=1.0, change=20.0),
)
"""Both by hand, in some forty runs of 4 s; checked with friction, strength and stiffness 20 % up
and down, and half the time step."""

EARTHWORM_STRENGTH = (1.2e6, 4e5)
INCHWORM_STRENGTH = (2.4e6, 2e5)
"""Pa, of the longitudinal and of the radial muscles. An arch is what stronger lower strands make; a
strong radial muscle would lengthen the body against them, and change its volume."""

FORWARD = DirectionalFriction(region="belly", factors=(1.0, 1.0, 10.0, 1.0))
"""Backward, friction is ten times as large (the paper's)."""

FRICTION = replace(PUSH_SETTINGS[-1], default=0.2)
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
SETTINGS = (PUSH, PUSH_SETTINGS[1], FRICTION)
START = 0.5  # s


def crawling_letter(strengths: tuple[float, float]) -> Character:
    """Flat letter I with muscles of these strengths (longitudinal, radial) and a rough belly."""
    letter = letter_i_flat()
    muscles = tuple(
        replace(group, strength=strength)
        for group, strength in zip(letter.muscles, strengths, strict=True)
    )
    material = replace(letter.material, volume="exact")
    return replace(letter, material=material, muscles=muscles, directional_friction=(FORWARD,))


def segments_of(character: Character, prefix: str) -> tuple[int, ...]:
    """Segments of the fibres whose names begin so."""
    found: list[int] = []
    first = 0
    for fiber in character.fibers:
        if fiber.name.startswith(prefix):
            found += range(first, first + fiber.segment_count)
        first += fiber.segment_count
    return tuple(found)


def _build(
    values: Values, strengths: tuple[float, float], gains: CrawlGains, resting: str | None = None
) -> tuple[Scene, Crawl]:
    character = crawling_letter(strengths)
    scene = Scene(
        character=character,
        ground=Plane(friction=values["friction"]),
        pushes=head_push(character, values),
    )
    still = segments_of(character, resting) if resting else ()
    return scene, Crawl(gains, start=START, resting=still)


def build_earthworm(values: Values) -> tuple[Scene, Crawl]:
    """Shorten and lengthen along the ground."""
    return _build(values, EARTHWORM_STRENGTH, EARTHWORM)


def build_inchworm(values: Values) -> tuple[Scene, Crawl]:
    """Arch and stretch; the upper muscles may not contract."""
    return _build(values, INCHWORM_STRENGTH, INCHWORM, resting="longitudinal_upper")


CRAWL_I = SceneRecipe(
    name="crawl-i",
    description="flat letter I crawls as an earthworm, ten cycles",
    settings=SETTINGS,
    build=build_earthworm,
    seconds=12.5,
    time_step=1.0 / 60.0,
)

CRAWL_I_INCHWORM = SceneRecipe(
    name="crawl-i-inchworm",
    description="flat letter I crawls as an inchworm, ten cycles",
    settings=SETTINGS,
    build=build_inchworm,
    seconds=12.5,
    time_step=1.0 / 60.0,
)
