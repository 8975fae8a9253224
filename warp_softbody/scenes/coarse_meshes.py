"""Scenes of letters share a setting for the letter's coarser meshes."""

from __future__ import annotations

from warp_softbody.characters.coarser_meshes import LONGER_EDGES
from warp_softbody.scenes.plan import Setting


def coarse_setting(letter: str) -> Setting:
    """How much coarser than usual the letter's mesh is."""
    return Setting(
        name="coarse",
        whole=True,
        default=0.0,
        low=0.0,
        high=float(len(LONGER_EDGES[letter])),
        help="coarser meshes of the letter, 0 for the usual one",
    )
