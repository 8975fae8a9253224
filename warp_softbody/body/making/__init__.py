"""From a stranger's surface, or tet mesh, to all that a character is made of."""

from __future__ import annotations
