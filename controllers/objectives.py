"""Objectives as a few linear rows in the next velocities v+ (docs/method.md section 4).

Paper eq. 12-18. Every objective is ``sum_i weight_i (rows_i v+ - target_i)^2``; rows (k, 3n) act on
velocities in node order (x, y, z of node 0, then of node 1, ...). Positions of the next step are x
+ dt v+, so position goals are rows too.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.body_units import LEAST_GRAVITY, BodyUnits
from warp_softbody.controllers.contact_frames import contact_frame
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import Value
from warp_softbody.world.native_measures import BaseArea
from warp_softbody.world.view import BodyView

DOUBLE = np.dtype(np.float64)

LARGEST = 1e12
"""Size of a row's, target's or weight's numbers beyond which an objective is refused: what else is
wanted would be lost in its rounding. In units of m g dt rows are some 1 to 1e4."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Objective(Value):
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
        if self._is_ready():
            return
        name = input_kinds.name("Objective.name", self.name)
        rows = array_checks.array(
            f"objective {name!r}: rows", self.rows, (None, None), finite=False
        )
        checks.keep(self, rows=_sized(name, "rows", rows))
        for field in ("target", "weight"):
            label = f"objective {name!r}: {field}"
            value = array_checks.array(label, getattr(self, field), None, finite=False)
            if value.shape != (len(rows),):
                if value.size != 1:
                    raise InputError(
                        f"{label} must be one number or {len(rows)}, one a row, "
                        f"not of shape {value.shape}"
                    )
                value = np.full(len(rows), value.item())
            checks.keep(self, **{field: _sized(name, field, value)})
        if self.weight.size and np.minimum.reduce(self.weight) < 0.0:
            raise InputError(f"objective {name!r}: weight must not be negative")

    def _is_ready(self) -> bool:
        """Whether nothing is wrong; told fast, for what is made in every step."""
        rows, target, weight = self.rows, self.target, self.weight
        if not (type(rows) is type(target) is type(weight) is np.ndarray):
            return False
        # NumPy has one object for the type of all plain arrays of double precision
        if not (rows.dtype is target.dtype is weight.dtype is DOUBLE):
            return False
        if rows.ndim != 2 or not target.shape == weight.shape == rows.shape[:1]:
            return False
        input_kinds.name("Objective.name", self.name)
        # no square is larger than the sum of all
        size = np.vdot(rows, rows) + np.vdot(target, target) + np.vdot(weight, weight)
        return bool(size <= LARGEST * LARGEST) and min(weight.tolist(), default=0.0) >= 0.0


def _is_small(values: FloatArray) -> bool:
    # no square is larger than the sum of all
    return bool(np.vdot(values, values) <= LARGEST * LARGEST)


def _each(weight: npt.ArrayLike, rows: FloatArray) -> FloatArray:
    """One for each row, where one number is given for all."""
    if not isinstance(weight, float):
        return np.asarray(weight)
    every = np.empty(len(rows))
    every[:] = weight
    return every


def _sized(name: str, field: str, values: FloatArray) -> FloatArray:
    """Numbers whose squares and sums a solver can bear."""
    if not _is_small(values):
        _refuse_large(name, field, values)
    return values


def _refuse_large(name: str, field: str, values: FloatArray) -> None:
    if not (-LARGEST <= values.min() and values.max() <= LARGEST):
        place = np.argwhere(~(np.abs(values) <= LARGEST))[0]
        raise InputError(
            f"objective {name!r}: {field} must be finite and at most {LARGEST:g} in size, "
            f"got {values[tuple(place)]} at {tuple(int(i) for i in place)}"
        )


def momentum_rows(view: BodyView) -> FloatArray:
    """L = rows v, (3, 3n)."""
    return mean_rows(view, view.masses)


def angular_momentum_rows(view: BodyView) -> FloatArray:
    """H about the centre of mass = rows v, (3, 3n)."""
    return view.turning


def mean_rows(view: BodyView, weights: FloatArray) -> FloatArray:
    """Velocity of the weighted mean of nodes, (3, 3n).

    The weights (n,) sum to one, or to zero for a difference of two means.
    """
    rows = np.zeros((3, view.node_count, 3))
    np.einsum("ana->na", rows)[...] = weights[:, None]
    return rows.reshape(3, -1)


def weight_of(view: BodyView) -> float:
    """The body's weight, N, as the unit of forces.

    Raises:
        InputError: the scene has no gravity worth the name.
    """
    if not view.weight > LEAST_GRAVITY * view.mass:
        raise InputError(
            "a controller that reckons in body weights needs gravity, but Scene.gravity is "
            f"{view.scene.gravity}"
        )
    return view.weight


def linear_momentum(view: BodyView, rate: FloatArray, weight: npt.ArrayLike = 1.0) -> Objective:
    """``|dL - dL*|^2`` (eq. 12-13) for a wanted rate dL* (3,) N, in units of m g dt."""
    unit = 1.0 / (weight_of(view) * view.horizon)
    target = (view.linear_momentum + view.horizon * rate) * unit
    rows = view.kept("rows of the momentum", lambda: momentum_rows(view) * unit)
    return Objective(name="linear momentum", rows=rows, target=target, weight=_each(weight, rows))


def angular_momentum(
    view: BodyView,
    rate: FloatArray,
    weight: npt.ArrayLike = 1.0,
    *,
    arm: float | None = None,
) -> Objective:
    """``|dH - dH*|^2`` (eq. 14) about the centre of mass for a wanted rate dH* (3,) N m.

    In units of m g dt times an arm, m; default the body's length L.
    """
    arm = BodyUnits.of(view).length if arm is None else arm
    unit = 1.0 / (weight_of(view) * view.horizon * arm)
    target = (view.angular_momentum + view.horizon * rate) * unit
    rows = angular_momentum_rows(view) * unit
    return Objective(name="angular momentum", rows=rows, target=target, weight=_each(weight, rows))


def base_area(
    view: BodyView, triangles: npt.NDArray[np.integer], growth: float, weight: float
) -> Objective:
    """``|dA - dA*|^2`` (eq. 15-16): growth of the base's area projected on the ground.

    Positions are taken at n and velocities at n + 1, so the row is the gradient of the projected
    area of the base triangles (f, 3), over that area; ``growth`` is the wanted relative rate, 1/s.
    In units of sqrt(g / L).
    """
    ground = view.scene.ground
    tangents = contact_frame(ground.normal if ground is not None else (0.0, 0.0, 1.0))[1:]
    if view.workroom is None:
        area, gradient = _area_of(view.positions, triangles, tangents)
    else:
        key = ("base area", triangles.tobytes())
        known: BaseArea = view.kept(key, lambda: BaseArea(view.node_count, triangles, tangents))
        area, gradient = known.find(view.positions)
    if not area > 0.0:
        raise InputError("objective 'base area': the base covers no area of the ground")
    unit = BodyUnits.of(view).time
    rows = (unit / area) * gradient.reshape(1, -1)
    return Objective(
        name="base area", rows=rows, target=np.array([growth * unit]), weight=np.array([weight])
    )


def _area_of(
    positions: FloatArray, triangles: npt.NDArray[np.integer], tangents: FloatArray
) -> tuple[float, FloatArray]:
    """Area, m^2, of triangles along two tangents, and its gradient (n, 3)."""
    flat = positions[triangles] @ tangents.T
    ahead, behind = flat[:, [1, 2, 0]], flat[:, [2, 0, 1]]
    turned = np.stack([ahead[..., 1] - behind[..., 1], behind[..., 0] - ahead[..., 0]], axis=-1)
    doubled = np.sum(flat * turned, axis=(1, 2)) / 2.0
    pull = ((np.sign(doubled)[:, None, None] * turned) @ tangents).reshape(-1, 3)
    corners = triangles.ravel()
    gradient = [np.bincount(corners, along, len(positions)) for along in pull.T]
    return float(np.abs(doubled).sum()), np.stack(gradient, axis=1)


def position(
    view: BodyView,
    weights: FloatArray,
    goal: FloatArray,
    weight: npt.ArrayLike = 1.0,
    *,
    unit: float | None = None,
) -> Objective:
    """``|f(x+) - p*|^2`` (eq. 17), f a weighted mean of nodes or a difference, goal (3,) m.

    In units of a length, m; default the body's length L.
    """
    share = 1.0 / (BodyUnits.of(view).length if unit is None else unit)
    rows = mean_rows(view, (view.horizon * share) * weights)
    target = share * (goal - weights @ view.positions)
    return Objective(name="position", rows=rows, target=target, weight=_each(weight, rows))


def velocity(
    view: BodyView,
    weights: FloatArray,
    goal: FloatArray,
    weight: npt.ArrayLike = 1.0,
    *,
    unit: float | None = None,
    stays: Hashable = None,
) -> Objective:
    """``|f(v+) - v*|^2`` (eq. 18), f a weighted mean of nodes or a difference, goal (3,) m/s.

    In units of a speed, m/s; default sqrt(g L). ``stays`` names weights that are the same in all
    steps of a run, in the same unit, so that their rows are made once.
    """
    share = 1.0 / (BodyUnits.of(view).speed if unit is None else unit)

    def made() -> FloatArray:
        return mean_rows(view, share * weights)

    rows = made() if stays is None else view.kept(("velocity", stays), made)
    return Objective(name="velocity", rows=rows, target=share * goal, weight=_each(weight, rows))
