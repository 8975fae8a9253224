"""In which directions along the ground a patch knows friction: they belong to the motion.

The plan's cone is a polygon, and what it has for friction depends on how that lies. It lies along
the sliding of the patch, which full friction then opposes; at rest along the body, whose own axes
are carried with it. So a body that is turned, or slides another way, is planned for alike.
"""

from __future__ import annotations

import cmath
from functools import lru_cache

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh import TetMesh
from warp_softbody.world.view import BodyView

SLIDING = 0.02
"""sqrt(g L): speed along the ground from which on the polygon lies along the sliding."""

Vector = tuple[float, float, float]


@lru_cache(maxsize=64)
def contact_frame(normal: Vector) -> FloatArray:
    """Rows normal, tangent 1, tangent 2: right-handed, tangent 1 along x where possible."""
    n = np.array(normal)
    axis = np.array([1.0, 0.0, 0.0]) if abs(n[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = axis - (axis @ n) * n
    first /= np.linalg.norm(first)
    frame = np.stack([n, first, np.cross(n, first)])
    frame.setflags(write=False)
    return frame


def carried_axes(view: BodyView) -> FloatArray:
    """Rows x, y and z (3, 3) of the rest shape, as the body carries them.

    They are the columns of the matrix that takes the rest shape nearest to the present one, nodes
    weighted by their masses.
    """
    mesh = view.scene.character.mesh
    count = len(mesh.points)
    nearest = _nearest_map(mesh, view.masses[:count].tobytes())
    axes: FloatArray = nearest @ view.positions[:count]
    return axes


@lru_cache(maxsize=8)
def _nearest_map(mesh: TetMesh, masses: bytes) -> FloatArray:
    """What takes positions (n, 3) to the matrix that takes the rest shape nearest to them, (3, n).

    By least squares; masses are float64, (n,) kg.
    """
    weights = np.frombuffer(masses)
    arms = (mesh.points - weights @ mesh.points / weights.sum()) * weights[:, None]
    found: FloatArray = np.linalg.solve(arms.T @ mesh.points, arms.T)
    return found


def moving_frame(normal: Vector, slip: FloatArray, axes: FloatArray, speed: float) -> FloatArray:
    """Rows normal, tangent 1, tangent 2 of a patch: right-handed, tangent 1 along the motion.

    A polygon of 4 or 8 directions is the same after a quarter turn. In complex numbers along the
    ground, that is the angle of a fourth power, of which a sum is smooth in all that is added:
    that of the sliding, over the speed from which on it decides, and those of the body's axes.

    Args:
        normal: unit, of the ground.
        slip: (3,) m/s, of the patch.
        axes: (3, 3), rows, which the body carries; some are not along the normal.
        speed: m/s, from which on the sliding decides.
    """
    frame = contact_frame(normal)
    tangents = frame[1:].T
    # few numbers: Python's own are faster than arrays
    ways = [complex(*along) for along in (axes @ tangents).tolist()]
    ways.append(complex(*(slip @ tangents).tolist()) / speed)
    # forward as the body has it: x and, where that is upright, y a quarter back
    forward = ways[0] - 1j * ways[1]
    size = abs(forward)
    forward = forward / size if size > 0.0 else 1.0 + 0.0j
    turned = sum(way**4 for way in ways) * forward.conjugate() ** 4
    way = forward * cmath.exp(0.25j * cmath.phase(turned))
    moving: FloatArray = frame.copy()
    moving[1] = way.real * frame[1] + way.imag * frame[2]
    moving[2] = way.real * frame[2] - way.imag * frame[1]
    return moving
