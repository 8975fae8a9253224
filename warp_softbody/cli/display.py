"""Whether this machine has a display."""

from __future__ import annotations

import os
import sys


def has_display() -> bool:
    """Whether a browser's window could be seen."""
    return sys.platform == "darwin" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))
