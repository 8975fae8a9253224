"""Scenes as TOML files: `read` one, `write` one (docs/scene-files.md)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warp_softbody.scene_files.reading import read_scene_file as read
    from warp_softbody.scene_files.scene_file import RunOutput, SceneFile
    from warp_softbody.scene_files.writing import write_scene_file as write

_HOMES = {
    "RunOutput": ("scene_file", "RunOutput"),
    "SceneFile": ("scene_file", "SceneFile"),
    "read": ("reading", "read_scene_file"),
    "write": ("writing", "write_scene_file"),
}

__all__ = ["RunOutput", "SceneFile", "read", "write"]


def __getattr__(name: str) -> Any:
    """Load a public name on first use (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home, attribute = _HOMES[name]
    return getattr(import_module(f"{__name__}.{home}"), attribute)
