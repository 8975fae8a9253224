"""The runs by which a candidate is judged: variations joined by " + ", and settings among them.

"as shipped"    "dt / 2 + linear elements"    "coarser mesh + push=0.5 + side=135"
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from benchmarks.fidelity.variants import VARIANTS
from benchmarks.robustness.variation import Variation
from benchmarks.robustness.variations import VARIATIONS
from warp_softbody import scenes
from warp_softbody.errors import InputError

KNOWN = {**VARIATIONS, **VARIANTS}
SIDE = "side"
"""Degrees by which the pushes are turned about the vertical; no setting of a scene."""


def family(scene: str, texts: Iterable[str]) -> tuple[Variation, ...]:
    """The members of a family, each named by its text.

    Raises:
        InputError: a text is no variation and no setting of the scene, or stands there twice.
    """
    texts = tuple(texts)
    if not texts or len(set(texts)) < len(texts):
        raise InputError("a family needs at least one member, and each one once")
    return tuple(_member(scene, text) for text in texts)


def _member(scene: str, text: str) -> Variation:
    parts = [_part(scene, part.strip()) for part in text.split(" + ")]
    return Variation(
        name=text,
        friction=math.prod(part.friction for part in parts),
        stiffness=math.prod(part.stiffness for part in parts),
        time_step=math.prod(part.time_step for part in parts),
        edges=math.prod(part.edges for part in parts),
        levels=sum(part.levels for part in parts),
        turn=sum(part.turn for part in parts),
        side=sum(part.side for part in parts),
        settings={name: value for part in parts for name, value in part.settings.items()},
        options={name: value for part in parts for name, value in part.options.items()},
    )


def _part(scene: str, text: str) -> Variation:
    if text in KNOWN:
        return KNOWN[text]
    name, equals, value = text.partition("=")
    if name == SIDE:
        return Variation(name=text, side=_number(text, value))
    settings = {setting.name: setting for setting in scenes.recipe(scene).settings}
    if not equals or name not in settings:
        raise InputError(
            f"{text!r} is no member of a family of {scene}: known are {', '.join(KNOWN)}, "
            f"{SIDE}=DEGREES, and NAME=VALUE for {', '.join(settings)}"
        )
    return Variation(name=text, settings={name: settings[name].parse(value)})


def _number(text: str, value: str) -> float:
    try:
        found = float(value)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise InputError(f"{text!r} is no number of degrees")
    return found
