"""USD stages, measures of them, pictures and movies are made in this room.

Names are resolved on first use, so that importing the package loads neither USD nor the renderer.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody.stage_exports.forms.convert import convert
    from warp_softbody.stage_exports.measures import Measures, measure, reversals
    from warp_softbody.stage_exports.pictures.movie import Movie
    from warp_softbody.stage_exports.pictures.picture import draw_picture
    from warp_softbody.stage_exports.pictures.sheet import draw_take, take_bounds
    from warp_softbody.stage_exports.pictures.still import draw_frame
    from warp_softbody.stage_exports.usd.reader import Take, body_names, read_take
    from warp_softbody.stage_exports.usd.recovery import recover
    from warp_softbody.stage_exports.usd.skin_files import read_skin
    from warp_softbody.stage_exports.usd.validation import validate
    from warp_softbody.stage_exports.usd.writer import StageWriter

_HOMES = {
    "convert": "forms.convert",
    "Measures": "measures",
    "Movie": "pictures.movie",
    "StageWriter": "usd.writer",
    "Take": "usd.reader",
    "body_names": "usd.reader",
    "draw_frame": "pictures.still",
    "draw_picture": "pictures.picture",
    "draw_take": "pictures.sheet",
    "measure": "measures",
    "read_skin": "usd.skin_files",
    "read_take": "usd.reader",
    "recover": "usd.recovery",
    "reversals": "measures",
    "take_bounds": "pictures.sheet",
    "validate": "usd.validation",
}

__all__ = [
    "Measures",
    "Movie",
    "StageWriter",
    "Take",
    "body_names",
    "convert",
    "draw_frame",
    "draw_picture",
    "draw_take",
    "measure",
    "read_skin",
    "read_take",
    "recover",
    "reversals",
    "take_bounds",
    "validate",
]


def __getattr__(name: str) -> Any:
    """Import the home of a public name."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
