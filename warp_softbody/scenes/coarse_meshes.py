"""Scenes of letters share a setting for the letter's coarser meshes."""

from __future__ import annotations

from warp_softbody.characters.coarser_meshes import LONGER_EDGES
from warp_softbody.scenes.plan import Setting


def coarse_setting(letter: str, shipped: int = 0) -> Setting:
    """How much coarser than the usual one the letter's mesh is; a scene ships with ``shipped``.

    That is the coarsest on which the motion is within 5 % of its reference and holds every variant
    of `benchmarks.fidelity` and `benchmarks.robustness`.
    """
    usual = "the usual one, with the paper's number of tets" if shipped else "the usual one"
    return Setting(
        name="coarse",
        whole=True,
        default=float(shipped),
        low=0.0,
        high=float(len(LONGER_EDGES[letter])),
        help=f"coarser meshes of the letter, 0 for {usual}",
    )
