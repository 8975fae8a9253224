"""Characters that ship with the package, each with its stored mesh."""

from __future__ import annotations

from warp_softbody.characters.letter_i import letter_i, letter_i_surface

__all__ = ["letter_i", "letter_i_surface"]
