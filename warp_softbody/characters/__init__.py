"""The shipped characters have a file each; their meshes are stored in the package."""

from __future__ import annotations

from warp_softbody.body.character import Character
from warp_softbody.characters.letter_f import letter_f
from warp_softbody.characters.letter_h import letter_h
from warp_softbody.characters.letter_i import letter_i, letter_i_jump, letter_i_surface
from warp_softbody.characters.letter_i_flat import letter_i_flat
from warp_softbody.characters.letter_o import letter_o
from warp_softbody.characters.letter_t import letter_t
from warp_softbody.characters.letter_x import letter_x
from warp_softbody.characters.letter_x_upright import letter_x_upright
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks

__all__ = [
    "letter_f",
    "letter_h",
    "letter_i",
    "letter_i_flat",
    "letter_i_jump",
    "letter_i_surface",
    "letter_o",
    "letter_t",
    "letter_x",
    "letter_x_upright",
    "make",
    "names",
]

_CHARACTERS = {
    character.__name__: character
    for character in (
        letter_h,
        letter_i,
        letter_i_jump,
        letter_f,
        letter_t,
        letter_o,
        letter_x,
        letter_x_upright,
        letter_i_flat,
    )
}


def names() -> tuple[str, ...]:
    """Return the names of all characters."""
    return tuple(_CHARACTERS)


def make(name: str) -> Character:
    """Return the character of a name.

    Raises:
        InputError: there is none of that name.
    """
    if not isinstance(name, str) or name not in _CHARACTERS:
        raise InputError(
            f"there is no character {checks.shown(name)}; there are: {', '.join(names())}"
        )
    return _CHARACTERS[name]()
