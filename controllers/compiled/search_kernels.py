"""Kernels of the native solve, to be compiled early: the search takes longest of all."""

from __future__ import annotations

from typing import Any

from warp_softbody.kernels.control.contact_patches import make_contact_patches
from warp_softbody.kernels.control.contact_search import make_contact_search


def search_kernels() -> list[Any]:
    """One kernel of each module that a controlled step launches on a processor."""
    return [make_contact_search().solve, make_contact_patches().find]
