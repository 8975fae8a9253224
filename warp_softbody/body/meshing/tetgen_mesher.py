"""TetGen keeps the surface exactly and repeats its mesh; it is optional (AGPL)."""

from __future__ import annotations

import importlib.metadata
import importlib.util
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from warp_softbody.body.meshing.child import Arrays, run_mesher
from warp_softbody.errors import MissingExtraError

TIMEOUT = 600.0

ENVELOPE = 1e-6
"""How far the mesh's surface may lie from the given one, relative to the box's diagonal."""

QUALITY: Mapping[str, object] = {
    "minratio": 1.4,
    "mindihedral": 12.0,
    "optmaxdihedral": 150.0,
}
"""Quality asked for: the best compromise on a box, a sphere and a letter; TetGen may miss it."""

VOLUME_FACTOR = 0.2
"""Largest volume over size cubed at which the mean edge comes out close to the size."""


def tetgen_version() -> str | None:
    """Version of the installed tetgen package, or None."""
    try:
        return importlib.metadata.version("tetgen")
    except importlib.metadata.PackageNotFoundError:
        return None


def require_tetgen() -> None:
    """Raise MissingExtraError, saying how to install TetGen, when it is not there."""
    if importlib.util.find_spec("tetgen") is None:
        raise MissingExtraError(
            "the mesher 'tetgen' is not installed; "
            "pip install \"warp-softbody[tetgen]\" brings it, or use the mesher 'ftetwild'"
        )


def options_for_size(size: float) -> dict[str, object]:
    """Options of `tetgen.TetGen.tetrahedralize` for a target edge length, m."""
    return {**QUALITY, "fixedvolume": True, "maxvolume": VOLUME_FACTOR * size**3}


def mesh_with_tetgen(
    points: npt.NDArray[np.float64],
    faces: npt.NDArray[np.int32],
    options: Mapping[str, object],
    *,
    source: str,
    timeout: float = TIMEOUT,
) -> Arrays:
    """Fill a closed surface, points (n, 3) m and faces (f, 3), by TetGen in a child process.

    Raises:
        MissingExtraError: TetGen is not installed.
        MeshError: TetGen refused the surface, crashed or took too long.
    """
    require_tetgen()
    return run_mesher("tetgen", points, faces, options, source=source, timeout=timeout)
