"""In which directions along the ground a patch knows friction: they belong to the motion.

The plan's cone is a polygon, and what it has for friction depends on how that lies. It lies along
the sliding of the patch, which full friction then opposes; at rest along the body, whose own axes
are carried with it. So a body that is turned, or slides another way, is planned for alike.
"""

from __future__ import annotations

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
    axes: FloatArray = nearest_map(view) @ view.positions[: len(view.scene.character.mesh.points)]
    return axes


def nearest_map(view: BodyView) -> FloatArray:
    """What takes the character's positions (own, 3) to the axes that it carries, (3, own)."""
    mesh = view.scene.character.mesh
    return _nearest_map(mesh, view.masses[: len(mesh.points)].tobytes())


@lru_cache(maxsize=8)
def _nearest_map(mesh: TetMesh, masses: bytes) -> FloatArray:
    """What takes positions (n, 3) to the matrix that takes the rest shape nearest to them, (3, n).

    By least squares; masses are float64, (n,) kg.
    """
    weights = np.frombuffer(masses)
    arms = (mesh.points - weights @ mesh.points / weights.sum()) * weights[:, None]
    found: FloatArray = np.linalg.solve(arms.T @ mesh.points, arms.T)
    return found


def moving_frames(
    normals: FloatArray, slips: FloatArray, axes: FloatArray, speed: float
) -> FloatArray:
    """Frames (p, 3, 3) of patches: rows normal, tangent 1, tangent 2, right-handed.

    Tangent 1 is along the motion. A polygon of 4 or 8 directions is the same after a quarter turn.
    In complex numbers along the ground, that is the angle of a fourth power, of which a sum is
    smooth in all that is added: that of the sliding, over the speed from which on it decides, and
    those of the body's axes.

    Args:
        normals: (p, 3), unit, of the ground.
        slips: (p, 3) m/s, of the patches.
        axes: (3, 3), rows, which the body carries; some are not along the normals.
        speed: m/s, from which on the sliding decides.
    """
    frames = np.array([contact_frame((x, y, z)) for x, y, z in normals.tolist()])
    motions = np.concatenate([np.tile(axes, (len(slips), 1, 1)), slips[:, None] / speed], axis=1)
    along = motions @ frames[:, 1:].transpose(0, 2, 1)
    ways = along[:, :, 0] + 1j * along[:, :, 1]
    # forward as the body has it: x and, where that is upright, y a quarter back
    forward = ways[:, 0] - 1j * ways[:, 1]
    sizes = np.abs(forward)
    forward = np.where(sizes > 0.0, forward, 1.0) / np.where(sizes > 0.0, sizes, 1.0)
    fourth = np.add.reduce(ways**4, axis=1) * forward.conj() ** 4
    way = (forward * np.exp(0.25j * np.angle(fourth)))[:, None]
    first, second = frames[:, 1].copy(), frames[:, 2].copy()
    frames[:, 1] = way.real * first + way.imag * second
    frames[:, 2] = way.real * second - way.imag * first
    return frames
