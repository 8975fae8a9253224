"""fTetWild: takes flawed surfaces and follows them within an envelope.

Two runs do not give the same mesh.
"""

from __future__ import annotations

import importlib.util

import numpy as np

from warp_softbody.body.meshing.child import Arrays, run_mesher
from warp_softbody.body.meshing.surface import Surface
from warp_softbody.errors import MeshError, MissingExtraError

LEAST_SECONDS, MOST_SECONDS = 45.0, 900.0
"""Bounds on the time that fTetWild is given, s."""

SECONDS_PER_CELL = 0.02
"""Time given for each tet that the size asks for, and for each triangle of the surface: some ten
times what fTetWild takes where the body is not thin."""

TETS_PER_CUBE = 12.0
"""Tets in a cube of the size, as they are asked for."""

ENVELOPE = 1e-3
"""How far the mesh's surface may lie from the given one, relative to the box's diagonal."""

IDEAL_LENGTH = 0.75
"""fTetWild's ideal edge length over the size; the mean edge comes out longer than the ideal."""


STOP_ENERGY = 10.0
"""Energy of its worst tet at which fTetWild stops; 3 is that of a regular one. One that is flatter
by a factor k has 2 k^(2/3), and a body that is thinner than the size by k is filled by such."""


def mesh_with_ftetwild(surface: Surface, size: float, *, timeout: float | None = None) -> Arrays:
    """Fill a surface by fTetWild in a child process.

    Args:
        surface: what to fill.
        size: target edge length, m.
        timeout: s; None for a limit that grows with the tets that the size asks for, so that a
            plate, whose thickness asks for many more, does not take minutes.

    Raises:
        MissingExtraError: pytetwild is not installed.
        MeshError: the body is thinner than what fTetWild may move its surface by, or fTetWild
            refused the surface, crashed or took too long.
    """
    if importlib.util.find_spec("pytetwild") is None:
        raise MissingExtraError(
            "the mesher 'ftetwild' is not installed; \"pip install pytetwild\" brings it"
        )
    _refuse_thinner_than_envelope(surface)
    thin = (
        f"the body is only some {surface.thickness:.3g} m thick, which asks for many tets; "
        f"use the mesher 'tetgen' or a thicker body"
    )
    # fTetWild has lengths of its own: a body of micrometres would never be done, or crash it.
    scale = 2.0 ** -np.floor(np.log2(surface.diagonal))
    middle = surface.bounds.mean(axis=0)
    flatness = size / surface.thickness
    options = {
        "stop_energy": max(STOP_ENERGY, 2.5 * flatness ** (2.0 / 3.0)),
        "edge_length_abs": IDEAL_LENGTH * size * scale,
        "epsilon": ENVELOPE,
        # Without it a large size is not met: a box of 51 tets comes out with 1,100.
        "coarsen": True,
        "quiet": True,
    }
    points, tets = run_mesher(
        "ftetwild",
        (surface.points - middle) * scale,
        surface.faces,
        options,
        source=surface.source,
        timeout=_time_limit(surface, size) if timeout is None else timeout,
        remedy=thin if surface.thickness < 0.2 * size else "",
    )
    return points / scale + middle, tets


def _refuse_thinner_than_envelope(surface: Surface) -> None:
    """Refuse a body whose two sides may be moved into each other."""
    reach = 2.0 * ENVELOPE * surface.diagonal
    if surface.thickness < reach:
        raise MeshError(
            f"{surface.source}: the body is only some {surface.thickness:.3g} m thick, but "
            f"ftetwild may move each side by {0.5 * reach:.3g} m; use the mesher 'tetgen', which "
            f"keeps the surface, or a thicker body"
        )


def _time_limit(surface: Surface, size: float) -> float:
    """Seconds allowed for a target edge length, m."""
    tets = TETS_PER_CUBE * surface.volume / size**3
    wanted = LEAST_SECONDS + SECONDS_PER_CELL * (tets + len(surface.faces))
    return float(min(wanted, MOST_SECONDS))
