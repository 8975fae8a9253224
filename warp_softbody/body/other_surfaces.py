"""Readers of surfaces from rooms that this one does not know: they are entered by the package."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from warp_softbody.body.skin import Skin

READERS: dict[str, Callable[[Path], Skin]] = {}
"""By extension, of files whose surface is in m with z upwards."""
