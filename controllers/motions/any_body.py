"""What motions need of a body that nobody has prepared for them: its regions, and common gains."""

from __future__ import annotations

from collections.abc import Sequence

from warp_softbody.body.character import Character
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

LEAST_FEET = 3
"""Feet on which a body stands without the moments that each of them bears."""


def require_regions(motion: str, character: Character, names: Sequence[str]) -> None:
    """Refuse a body that lacks a region or has an empty one.

    Raises:
        InputError: names the motion, the region and those that there are.
    """
    checks.instance(f"character of {motion}", character, Character)
    for name in names:
        if not len(character.regions.get(name, ())):
            known = ", ".join(sorted(character.regions)) or "none"
            raise InputError(
                f"{motion} needs nodes in the region {name!r}, but character {character.name!r} "
                f"has none there; its regions are: {known}"
            )


def require_muscles(motion: str, character: Character) -> None:
    """Refuse a body that nothing can drive.

    Raises:
        InputError: the character has no muscles.
    """
    checks.instance(f"character of {motion}", character, Character)
    if not character.muscles:
        raise InputError(f"{motion} needs muscles, but character {character.name!r} has none")


def feet_of(character: Character) -> tuple[str, ...]:
    """Regions through which a body stands: three feet or more, else the quadrants of its base.

    Feet are the regions `foot_...`, quadrants `base_patch_...`; empty ones are left out. Two feet
    are taken by their halves, as two points bear no moment about the line through them. A body
    without quadrants stands on its base.
    """
    feet, quadrants = (
        tuple(
            name
            for name in character.regions
            if name.startswith(beginning) and len(character.regions[name])
        )
        for beginning in ("foot_", "base_patch_")
    )
    return feet if len(feet) >= LEAST_FEET else quadrants or ("base",)
