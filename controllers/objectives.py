"""Objectives as a few linear rows in the next velocities v+ (docs/method.md section 4).

Paper eq. 12-18. Every objective is ``sum_i weight_i (rows_i v+ - target_i)^2``; rows (k, 3n) act on
velocities in node order (x, y, z of node 0, then of node 1, ...). Positions of the next step are x
+ dt v+, so position goals are rows too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.controllers.patches import contact_frame
from warp_softbody.errors import InputError
from warp_softbody.view import BodyView

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Objective:
    """Weighted squared distance of a few linear functions of v+ from their targets.

    Attributes:
        name: for messages and statistics.
        rows: (k, 3n).
        target: (k,).
        weight: (k,), >= 0.
    """

    name: str
    rows: FloatArray
    target: FloatArray
    weight: FloatArray

    def __post_init__(self) -> None:
        """Check shapes and numbers, so that a bad goal is named here and not in a solver."""
        count = len(self.rows)
        for field in ("target", "weight"):
            value = np.asarray(getattr(self, field), dtype=np.float64)
            if value.shape != (count,):
                value = np.broadcast_to(value, (count,))
            if not np.isfinite(value).all():
                raise InputError(f"objective {self.name!r}: {field} must be finite, got {value}")
            object.__setattr__(self, field, value)
        if (self.weight < 0.0).any():
            raise InputError(f"objective {self.name!r}: weight must not be negative")


def momentum_rows(view: BodyView) -> FloatArray:
    """L = rows v, (3, 3n)."""
    rows = np.zeros((3, view.node_count, 3))
    for axis in range(3):
        rows[axis, :, axis] = view.masses
    return rows.reshape(3, -1)


def angular_momentum_rows(view: BodyView) -> FloatArray:
    """H about the centre of mass = rows v, (3, 3n)."""
    arms = (view.positions - view.center_of_mass) * view.masses[:, None]
    rows = np.zeros((3, view.node_count, 3))
    rows[0, :, 1], rows[0, :, 2] = -arms[:, 2], arms[:, 1]
    rows[1, :, 0], rows[1, :, 2] = arms[:, 2], -arms[:, 0]
    rows[2, :, 0], rows[2, :, 1] = -arms[:, 1], arms[:, 0]
    return rows.reshape(3, -1)


def mean_rows(view: BodyView, weights: FloatArray) -> FloatArray:
    """Velocity of the weighted mean of nodes, (3, 3n).

    The weights (n,) sum to one, or to zero for a difference of two means.
    """
    rows = np.zeros((3, view.node_count, 3))
    for axis in range(3):
        rows[axis, :, axis] = weights
    return rows.reshape(3, -1)


def linear_momentum(view: BodyView, rate: FloatArray, weight: npt.ArrayLike = 1.0) -> Objective:
    """``|dL - dL*|^2`` (eq. 12-13) for a wanted rate dL* (3,) N, in units of m g dt."""
    unit = 1.0 / (view.weight * view.time_step)
    target = (view.linear_momentum + view.time_step * rate) * unit
    rows = momentum_rows(view) * unit
    return Objective(name="linear momentum", rows=rows, target=target, weight=np.asarray(weight))


def angular_momentum(
    view: BodyView, rate: FloatArray, weight: npt.ArrayLike = 1.0, arm: float = 1.0
) -> Objective:
    """``|dH - dH*|^2`` (eq. 14) about the centre of mass for a wanted rate dH* (3,) N m.

    In units of m g dt times the arm, m.
    """
    unit = 1.0 / (view.weight * view.time_step * arm)
    target = (view.angular_momentum + view.time_step * rate) * unit
    rows = angular_momentum_rows(view) * unit
    return Objective(name="angular momentum", rows=rows, target=target, weight=np.asarray(weight))


def base_area(
    view: BodyView, triangles: npt.NDArray[np.integer], growth: float, weight: float
) -> Objective:
    """``|dA - dA*|^2`` (eq. 15-16): growth of the base's area projected on the ground.

    Positions are taken at n and velocities at n + 1, so the row is the gradient of the projected
    area of the base triangles (f, 3), over that area; ``growth`` is the wanted relative rate, 1/s.
    """
    ground = view.scene.ground
    frame = contact_frame(ground.normal if ground is not None else (0.0, 0.0, 1.0))
    flat = view.positions[triangles] @ frame[1:].T
    ahead, behind = flat[:, [1, 2, 0]], flat[:, [2, 0, 1]]
    turned = np.stack([ahead[..., 1] - behind[..., 1], behind[..., 0] - ahead[..., 0]], axis=-1)
    doubled = np.sum(flat * turned, axis=(1, 2)) / 2.0
    pull = ((np.sign(doubled)[:, None, None] * turned) @ frame[1:]).reshape(-1, 3)
    corners = triangles.ravel()
    gradient = [np.bincount(corners, along, view.node_count) for along in pull.T]
    rows = (np.stack(gradient, axis=1) / np.abs(doubled).sum()).reshape(1, -1)
    return Objective(
        name="base area", rows=rows, target=np.array([growth]), weight=np.array([weight])
    )


def position(
    view: BodyView, weights: FloatArray, goal: FloatArray, weight: npt.ArrayLike = 1.0
) -> Objective:
    """``|f(x+) - p*|^2`` (eq. 17), f a weighted mean of nodes or a difference, goal (3,) m."""
    now = weights @ view.positions
    rows = mean_rows(view, weights) * view.time_step
    return Objective(name="position", rows=rows, target=goal - now, weight=np.asarray(weight))


def velocity(
    view: BodyView, weights: FloatArray, goal: FloatArray, weight: npt.ArrayLike = 1.0
) -> Objective:
    """``|f(v+) - v*|^2`` (eq. 18), f a weighted mean of nodes or a difference, goal (3,) m/s."""
    rows = mean_rows(view, weights)
    return Objective(name="velocity", rows=rows, target=goal, weight=np.asarray(weight))
