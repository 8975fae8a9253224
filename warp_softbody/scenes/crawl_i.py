"""The flat letter I crawls, as an earthworm and as an inchworm (the paper's crawling I)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from warp_softbody.body.character import Character
from warp_softbody.body.directional_friction import DirectionalFriction
from warp_softbody.characters import letter_i_flat
from warp_softbody.controllers.controller import ActivationCost
from warp_softbody.controllers.motions.crawl import Crawl, CrawlGains
from warp_softbody.scenes.coarse_meshes import coarse_setting
from warp_softbody.scenes.plan import SceneRecipe, Values
from warp_softbody.scenes.pushes import PUSH_SETTINGS, head_push
from warp_softbody.scenes.uneven_ground import GROUND_SETTINGS, ground_ahead
from warp_softbody.world.scene import Scene

EARTHWORM = CrawlGains(
    stride=0.12,  # L
    activation=ActivationCost(effort=1.0, change=1.253),
)
INCHWORM = CrawlGains(
    stride=0.28,  # L, which it reaches however its motion is computed
    arch=0.3,  # L, more than it reaches: the stride decides how high it gets
    pull_time=1.558,  # sqrt(L/g)
    push_time=2.2,  # sqrt(L/g): a body that falls faster pushes its tail back
    follow=2.235,  # sqrt(g/L)
    hold=0.4,  # sqrt(g/L): held to its place, the tail stops the body from going flat
    corner_weight=0.1,  # sqrt(L/g)
    side_weight=0.06,  # sqrt(L/g): with a sixth of it the body drifts off its way, by up to 0.13 L
    ground_weight=0.0,  # the ends stand on their edges
    middle_weight=0.35,  # sqrt(L/g)
    activation=ActivationCost(effort=1.0, change=0.6264),
)
"""By hand; checked by `python -m benchmarks.fidelity --scenes crawl-i crawl-i-inchworm`."""

INCHWORM_MATERIAL = {"young_modulus": 6e5, "poisson_ratio": 0.455, "stiffness_damping": 0.1}
"""Pa, none, s: firmer, so that weaker muscles arch it as high; and of a volume that changes by 3 %
at most beside them, not by 3.5. With 0.46 linear elements arch by less than 0.2 m."""

EARTHWORM_STRENGTH = (2.4, 0.8)
INCHWORM_STRENGTH = (6.0, 0.4)
"""E, of the longitudinal and of the radial muscles. An arch is what stronger lower strands make; a
strong radial muscle would lengthen the body against them, and change its volume."""

FORWARD = DirectionalFriction(region="belly", factors=(1.0, 1.0, 10.0, 1.0))
"""Backward, friction is ten times as large (the paper's)."""

FRICTION = replace(PUSH_SETTINGS[-1], default=0.2)
PUSH = replace(PUSH_SETTINGS[0], default=0.0)
SETTINGS = (PUSH, PUSH_SETTINGS[1], FRICTION, coarse_setting("letter_i_flat"), *GROUND_SETTINGS)
START = 1.566  # sqrt(L/g)


def crawling_letter(
    strengths: tuple[float, float],
    coarse: float = 0.0,
    changes: Mapping[str, Any] = MappingProxyType({}),
) -> Character:
    """Flat letter I with muscles of strengths in E (longitudinal, radial) and a rough belly.

    ``changes`` are of its material.
    """
    letter = letter_i_flat(coarse=int(coarse))
    material = replace(letter.material, volume="exact", **dict(changes))
    muscles = tuple(
        replace(group, strength=strength * material.young_modulus)
        for group, strength in zip(letter.muscles, strengths, strict=True)
    )
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
    values: Values, character: Character, gains: CrawlGains, resting: tuple[int, ...] = ()
) -> tuple[Scene, Crawl]:
    scene = Scene(
        character=character,
        ground=ground_ahead(values),
        pushes=head_push(character, values),
    )
    return scene, Crawl(gains, start=START, resting=resting)


def build_earthworm(values: Values) -> tuple[Scene, Crawl]:
    """Shorten and lengthen along the ground."""
    return _build(values, crawling_letter(EARTHWORM_STRENGTH, values["coarse"]), EARTHWORM)


def build_inchworm(values: Values) -> tuple[Scene, Crawl]:
    """Arch and stretch; the upper muscles may not contract."""
    character = crawling_letter(INCHWORM_STRENGTH, values["coarse"], INCHWORM_MATERIAL)
    return _build(values, character, INCHWORM, segments_of(character, "longitudinal_upper"))


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
