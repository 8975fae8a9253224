"""The motion of a body is measured from a stage alone: volumes, depth, tilt, base, reversals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.body.mesh_geometry import lumped_masses, tet_volumes
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.inputs.records import Value
from warp_softbody.stage_exports.usd.reader import Take
from warp_softbody.world.ground import Ground

# A skin triangle belongs to the base when it lies, at rest, in the lowest part of the body.
_BASE_BAND = 0.01

ROUNDING = 1e-5
"""m/s between frames: twice the speed that rounding in single precision leaves at rest. At 60 fps
that is 6e-4 m/s^2, and a swing to and fro of 0.1 micrometre."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Measures(Value):
    """What `measure` returns: one value for each frame.

    Attributes:
        times: (f,) s.
        penetration: (f,) m, how deep the deepest node is below the ground; 0 if none is.
        smallest_volume_ratio: (f,) signed volume of the most squeezed tet over its rest volume;
            negative when it is turned inside out.
        volume_change: (f,) volume of the body over its rest volume, minus one.
        centre_of_mass: (f, 3) m, of a body of one density.
        tilt: (f,) degrees between the body's rest vertical, carried along by the rotation that fits
            all nodes best, and z.
        base_area: (f,) m^2, of the skin that is lowest at rest, projected on the ground.
        finite: (f,) whether every position, velocity and activation is finite.
    """

    times: FloatArray
    penetration: FloatArray
    smallest_volume_ratio: FloatArray
    volume_change: FloatArray
    centre_of_mass: FloatArray
    tilt: FloatArray
    base_area: FloatArray
    finite: npt.NDArray[np.bool_]


def reversals(take: Take) -> float:
    """Return the share of node accelerations that point against those of the frame before.

    A node's acceleration turns against another when their dot product is negative. A body that
    shakes has many; it depends on the frame rate, so compare at 60 frames a second. Changes of
    velocity within ``ROUNDING`` are none, or a body that stands perfectly still would shake.
    """
    checks.instance("take of reversals", take, Take)
    if len(take) < 4:
        return 0.0
    change = np.diff(take.velocities, axis=0)
    change[np.linalg.norm(change, axis=2) < ROUNDING] = 0.0
    return float(((change[1:] * change[:-1]).sum(axis=2) < 0.0).mean())


def measure(take: Take) -> Measures:
    """Measure every frame of a take from its stored points.

    Raises:
        InputError: no take, or one whose body has no volume at rest, which everything is measured
            against.
    """
    checks.instance("take of measure", take, Take)
    rest_volumes = tet_volumes(take.rest, take.tets)
    whole = rest_volumes.sum()
    if not (np.isfinite(whole) and whole > 0.0):
        raise InputError(
            f"body {take.name!r} cannot be measured: its volume at rest is {whole:.3g} m^3"
        )
    # rounding in single precision may leave a sliver without a volume to compare with
    solid = rest_volumes > 0.0
    # Frame by frame: the corners of all tets of a long take at once would fill the memory.
    volumes = np.stack([tet_volumes(points, take.tets) for points in take.tet_points])
    masses = lumped_masses(take.tets, rest_volumes, len(take.rest))
    return Measures(
        times=take.times,
        penetration=_penetration(take.tet_points, take.ground),
        smallest_volume_ratio=np.min(volumes[:, solid] / rest_volumes[solid], axis=1),
        volume_change=volumes.sum(axis=1) / whole - 1.0,
        centre_of_mass=np.asarray(masses @ take.tet_points / masses.sum()),
        tilt=_tilt(take.rest, take.tet_points, masses),
        base_area=_base_area(take),
        finite=_finite(take.tet_points)
        & _finite(take.velocities)
        & np.isfinite(take.activations).all(axis=1),
    )


def _finite(series: FloatArray) -> npt.NDArray[np.bool_]:
    return np.asarray(np.isfinite(series).all(axis=(1, 2)))


def _penetration(points: FloatArray, ground: Ground | None) -> FloatArray:
    if ground is None:
        return np.zeros(len(points))
    deepest = [ground.measure(frame)[0].min() for frame in points]
    return np.asarray(np.maximum(0.0, -np.array(deepest)))


def _tilt(rest: FloatArray, points: FloatArray, masses: FloatArray) -> FloatArray:
    """Kabsch: the rotation R nearest to the mass-weighted covariance, by its z axis."""
    finite = _finite(points)
    tilt = np.full(len(points), np.nan)
    weights = masses / masses.sum()
    moved = points[finite] - (weights @ points[finite])[:, None, :]
    covariance = np.einsum("fni,nj->fij", moved, weights[:, None] * (rest - weights @ rest))
    left, _, right = np.linalg.svd(covariance)
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    axis = (left @ right)[:, :, 2]
    # atan2 keeps the digits that arccos loses near upright.
    tilt[finite] = np.degrees(np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))
    return tilt


def _base_area(take: Take) -> FloatArray:
    """Area of the base's triangles projected along the ground's normal (z without a ground)."""
    normal = np.array((0.0, 0.0, 1.0) if take.ground is None else take.ground.normal)
    height = take.skin_rest @ normal
    low = height <= height.min() + _BASE_BAND * np.ptp(height)
    corners = take.skin_points[:, take.skin_faces[low[take.skin_faces].all(axis=1)]]
    edges = corners[:, :, 1:] - corners[:, :, :1]
    return np.asarray(np.abs(np.cross(edges[:, :, 0], edges[:, :, 1]) @ normal).sum(axis=1) / 2.0)
