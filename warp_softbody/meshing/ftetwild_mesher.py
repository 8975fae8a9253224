"""fTetWild: takes flawed surfaces and follows them within an envelope.

Two runs do not give the same mesh.
"""

from __future__ import annotations

import importlib.util

from warp_softbody.errors import MissingExtraError
from warp_softbody.meshing.child import Arrays, run_mesher
from warp_softbody.meshing.surface import Surface

TIMEOUT = 900.0

ENVELOPE = 1e-3
"""How far the mesh's surface may lie from the given one, relative to the box's diagonal."""

IDEAL_LENGTH = 0.75
"""fTetWild's ideal edge length over the size; the mean edge comes out longer than the ideal."""


def mesh_with_ftetwild(surface: Surface, size: float, *, timeout: float = TIMEOUT) -> Arrays:
    """Fill a surface by fTetWild in a child process, with a target edge length in m.

    Raises:
        MissingExtraError: pytetwild is not installed.
        MeshError: fTetWild refused the surface, crashed or took too long.
    """
    if importlib.util.find_spec("pytetwild") is None:
        raise MissingExtraError(
            "the mesher 'ftetwild' is not installed; \"pip install pytetwild\" brings it"
        )
    options = {
        "edge_length_abs": IDEAL_LENGTH * size,
        "epsilon": ENVELOPE,
        # Without it a large size is not met: a box of 51 tets comes out with 1,100.
        "coarsen": True,
        "quiet": True,
    }
    return run_mesher(
        "ftetwild",
        surface.points,
        surface.faces,
        options,
        source=surface.source,
        timeout=timeout,
    )
