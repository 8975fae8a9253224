"""The feet of limbs around a body, each by the regions that are its parts."""

from __future__ import annotations

from collections import defaultdict

from warp_softbody.body.character import Character
from warp_softbody.controllers.motions.any_body import LEAST_FEET
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds

Feet = tuple[tuple[str, ...], ...]

FEET: Feet = tuple(tuple(f"foot_{limb}_{part}" for part in range(4)) for limb in range(4))
"""The parts of each foot of letter X as it stands upright."""


def checked_feet(feet: object) -> Feet:
    """The parts of each foot, as they were given.

    Raises:
        InputError: they are no names of regions, or those of too few feet.
    """
    wanted = f"tuples of names of regions, one for each of {LEAST_FEET} feet or more"
    given = checks.several("feet of Cartwheel", feet, wanted)
    if len(given) < LEAST_FEET:
        checks.refuse("feet of Cartwheel", wanted, feet)
    return tuple(input_kinds.names("a foot in the feet of Cartwheel", parts) for parts in given)


def feet_around(character: Character) -> Feet:
    """The regions `foot_NAME` of a body, each by its parts `foot_NAME_PART` where it has some.

    Raises:
        InputError: the body has too few.
    """
    found: dict[str, list[str]] = defaultdict(list)
    for name in character.regions:
        kind, *rest = name.split("_")
        if kind == "foot" and rest and len(character.regions[name]):
            found["_".join((kind, rest[0]))].append(name)
    if len(found) < LEAST_FEET:
        raise InputError(
            f"Cartwheel needs {LEAST_FEET} regions 'foot_...' or more around the body, but "
            f"character {character.name!r} has {len(found)}"
        )
    return tuple(
        tuple(part for part in parts if part != foot or len(parts) == 1)
        for foot, parts in found.items()
    )
