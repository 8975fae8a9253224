"""Pages of scenes and takes in a browser are made in this room.

Names are resolved on first use, as those of the package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody.live.html_take import HtmlTake

_HOMES = {"HtmlTake": "html_take"}

__all__ = ["HtmlTake"]


def __getattr__(name: str) -> Any:
    """Import the home of a public name."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """Public names, for completion."""
    return sorted(__all__)
