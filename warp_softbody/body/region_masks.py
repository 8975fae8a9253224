"""Regions by what holds of their nodes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks, input_kinds

__all__ = ["where"]


def where(
    mesh: TetMesh,
    condition: npt.ArrayLike | Callable[[FloatArray], npt.ArrayLike],
    *,
    skin: bool = False,
) -> npt.NDArray[np.int32]:
    """The nodes of a mesh for which something holds, as `Character.regions` takes them.

    Args:
        mesh: whose nodes they are.
        condition: a mask (n,) of any type, or node indices; or a function of the points (n, 3) m
            at rest that returns one, as ``lambda p: p[:, 2] > 0.5``.
        skin: whether nodes within the body are left out.

    Raises:
        InputError: it is no mask, or holds nowhere.
    """
    checks.instance("mesh of where", mesh, TetMesh)
    checks.truth("skin of where", skin)
    count = len(mesh.points)
    if callable(condition):
        condition = checks.called_with("condition of where", condition, 1, "a mask or a function")
        told = np.asarray(condition(mesh.points))
        if told.shape != (count,):
            raise InputError(
                f"condition of where must return a truth value for each of {count} points, not an "
                f"array of shape {told.shape}"
            )
        nodes = np.flatnonzero(told).astype(np.int32)
    else:
        nodes = np.array(input_kinds.node_set("condition of where", condition, count))
    if skin:
        nodes = np.intersect1d(nodes, mesh.surface_nodes).astype(np.int32)
    if not len(nodes):
        raise InputError("condition of where holds for no node of the mesh")
    return nodes
