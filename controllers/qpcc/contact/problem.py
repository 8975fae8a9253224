"""The contact form of a QPCC: the control problem of one step (docs/method.md, equation 11).

Minimise ``1/2 z'Qz + c'z + c0`` over the controls u and the contact impulses f, ``z = (u, f)``,
subject to ``lower <= u <= upper`` and, for every contact, Coulomb's law on a linearised cone with
m tangent directions d_j (docs/method.md section 3), where ``w = w0 + Wu u + Wf f`` is the contact
velocity:

    0 <= f_n    _|_  w_n >= 0
    0 <= beta_j _|_  d_j . w_t + lam >= 0          f_t = sum_j S_j beta_j d_j
    0 <= lam    _|_  mu f_n - sum_j beta_j >= 0

The factors S scale the force of each direction and not its velocity: friction opposes the sliding,
as in the simulator, and its size depends on the direction (docs/qpcc.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import lapack

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import FrozenValue, unchecked

MOST_FRICTION = 1e3
"""Friction beyond which cones are half spaces but for rounding, which would be all that is left."""

SYMMETRY_TOLERANCE = 1e-3
"""Relative asymmetry of ``velocity_from_forces`` up to which it may be rounding (1e-4 of it in
single precision)."""

CONVEXITY_TOLERANCE = 1e-9
"""Relative size of a negative eigenvalue of the Hessian up to which it may be rounding."""


def uniform_directions(count: int = 8) -> FloatArray:
    """Unit vectors (count, 2) of the tangent plane at equal angles, the first along tangent 1."""
    count = checks.whole("count of uniform_directions", count, low=3, high=10_000)
    copy: FloatArray = _uniform(count).copy()
    return copy


@lru_cache(maxsize=8)
def _uniform(count: int) -> FloatArray:
    angles = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _ones() -> FloatArray:
    """The default of the factors, ones, whose shape depends on the other arrays."""
    return np.zeros(0)


def _no_squares() -> FloatArray:
    return np.zeros((0, 0))


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ContactQPCC(FrozenValue):
    """One step's control problem; arrays are kept as read-only float64 copies.

    Local frame of a contact: (normal, tangent 1, tangent 2), the normal pointing out of the ground.
    Forces are impulses (N s), velocities m/s, controls in whatever unit the caller uses (l_d: m).

    Attributes:
        hessian: Q, (nu + 3K, nu + 3K), symmetric positive semidefinite.
        gradient: c, (nu + 3K,).
        constant: c0.
        lower: (nu,), may hold -inf.
        upper: (nu,), may hold +inf.
        velocity_offset: w0, (3K,), m/s; normal rows include gap / dt.
        velocity_from_controls: Wu, (3K, nu).
        velocity_from_forces: Wf, (3K, 3K), the Delassus matrix, symmetric up to rounding.
        friction: mu, (K,), >= 0, or one number for all contacts. Beyond `MOST_FRICTION` it is taken
            for that: the force then leaves the normal by less than 0.06 degrees of a right angle.
        directions: d_j, (m, 2) unit vectors ordered by angle, no gap of half a turn or more.
        factors: S, (K, m), > 0, on the friction by the direction of the force; default ones.
        squares: N, (r, nu + 3K), with ``Q = diag(d, 0) + N'N`` for a diagonal d over the controls,
            where that is known: the objective is then a sum of r squares and of the controls', and
            with few rows a solve costs less. Default none.
    """

    hessian: FloatArray
    gradient: FloatArray
    constant: float = 0.0
    lower: FloatArray
    upper: FloatArray
    velocity_offset: FloatArray
    velocity_from_controls: FloatArray
    velocity_from_forces: FloatArray
    friction: FloatArray
    directions: FloatArray = field(default_factory=uniform_directions)
    factors: FloatArray = field(default_factory=_ones)
    squares: FloatArray = field(default_factory=_no_squares)

    def __post_init__(self) -> None:
        """Convert, then check cones, numbers and convexity."""
        for name in (entry.name for entry in fields(self)):
            value = getattr(self, name)
            if name != "constant":
                plain = array_checks.array(f"ContactQPCC.{name}", value, None, finite=False)
                array = np.array(plain, np.float64, order="C")
                array.setflags(write=False)
                object.__setattr__(self, name, array)
        constant = checks.number("ContactQPCC.constant", self.constant, low=-1e300, high=1e300)
        checks.keep(self, constant=constant)
        for name in ("directions", "squares"):
            if getattr(self, name).ndim != 2:
                shape = getattr(self, name).shape
                raise InputError(f"ContactQPCC.{name} must be a matrix, not of shape {shape}")
        if self.friction.ndim == 0 and self.velocity_offset.ndim == 1:
            spread = np.full(self.velocity_offset.size // 3, float(self.friction))
            object.__setattr__(self, "friction", spread)
        if self.factors.size == 0:
            ones = np.ones((self.friction.size, self.directions.shape[0]))
            object.__setattr__(self, "factors", ones)
        self._check_shapes()
        self._check_numbers()
        held = np.minimum(self.friction, MOST_FRICTION)
        held.setflags(write=False)
        object.__setattr__(self, "friction", held)
        self._check_law()

    @property
    def control_count(self) -> int:
        """Number of controls, nu."""
        return self.lower.size

    @property
    def contact_count(self) -> int:
        """Number of contacts, K."""
        return self.friction.size

    @cached_property
    def diagonal(self) -> FloatArray:
        """The diagonal d of ``Q = diag(d, 0) + N'N``, (nu,)."""
        own: FloatArray = self.hessian.diagonal() - np.einsum(
            "ij,ij->j", self.squares, self.squares
        )
        return own[: self.control_count]

    @cached_property
    def scales(self) -> tuple[float, float]:
        """Typical contact velocity (m/s) and impulse (N s), the units of scaled quantities."""
        reach = 0.5 * (self.upper - self.lower)
        reach = np.where(np.isfinite(reach) & (reach > 0.0), reach, 1.0)
        spread = np.sqrt((self.velocity_from_controls**2) @ (reach**2))
        speed = float((np.abs(self.velocity_offset) + spread).max(initial=0.0)) or 1.0
        mobility = self.velocity_from_forces.trace() / max(spread.size, 1)
        return speed, speed / float(mobility) if mobility > 0.0 else 1.0

    def velocity(self, controls: FloatArray, forces: FloatArray) -> FloatArray:
        """``w0 + Wu u + Wf f``, (K, 3) m/s; forces (K, 3) N s."""
        flat = self.velocity_offset + self.velocity_from_controls @ controls
        return (flat + self.velocity_from_forces @ forces.reshape(-1)).reshape(-1, 3)

    def objective(self, controls: FloatArray, forces: FloatArray) -> float:
        """``1/2 z'Qz + c'z + c0`` at z = (u, f)."""
        z = np.concatenate([controls, forces.reshape(-1)])
        return float(z @ (0.5 * (self.hessian @ z) + self.gradient)) + self.constant

    def _check_shapes(self) -> None:
        if self.lower.ndim != 1 or self.lower.size == 0:
            raise InputError(
                f"ContactQPCC.lower must hold one number per control, not {self.lower.shape}"
            )
        nu, k, m = self.control_count, self.contact_count, len(self.directions)
        expected = {
            "hessian": (nu + 3 * k, nu + 3 * k),
            "gradient": (nu + 3 * k,),
            "upper": (nu,),
            "velocity_offset": (3 * k,),
            "velocity_from_controls": (3 * k, nu),
            "velocity_from_forces": (3 * k, 3 * k),
            "friction": (k,),
            "directions": (m, 2),
            "factors": (k, m),
        }
        if self.squares.size:
            expected["squares"] = (len(self.squares), nu + 3 * k)
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                given = getattr(self, name).shape
                raise InputError(f"ContactQPCC.{name} must be of shape {shape}, not {given}")

    def _check_numbers(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            # A finite sum has only finite terms.
            if math.isfinite(value if entry.name == "constant" else value.sum()):
                continue
            finite = np.isfinite(value)
            if entry.name in ("lower", "upper"):
                finite = ~np.isnan(value)
            if not np.all(finite):
                place = np.unravel_index(int(np.argmin(finite)), np.shape(value))
                raise InputError(
                    f"ContactQPCC.{entry.name} must be finite, but it holds "
                    f"{np.asarray(value)[place]} at {tuple(int(i) for i in place)}"
                )
        crossed = np.flatnonzero(~(self.lower <= self.upper))
        if crossed.size or np.any(self.lower == np.inf) or np.any(self.upper == -np.inf):
            i = int(crossed[0]) if crossed.size else int(np.argmax(np.abs(self.lower)))
            raise InputError(
                f"ContactQPCC.lower and upper of control {i} leave no value: "
                f"{self.lower[i]} to {self.upper[i]}"
            )

    def _check_law(self) -> None:
        if np.any(self.friction < 0.0) or np.any(self.factors <= 0.0):
            raise InputError(
                "ContactQPCC.friction must not be negative and ContactQPCC.factors must be "
                f"positive, the least are {self.friction.min()} and {self.factors.min()}"
            )
        _check_directions(self.directions.tobytes())
        _check_symmetric("velocity_from_forces", self.velocity_from_forces, SYMMETRY_TOLERANCE)
        if self.squares.size:
            self._check_squares()
            return
        _check_symmetric("hessian", self.hessian, 1e-6)
        shifted = self.hessian.copy()
        size = float(shifted.diagonal().max()) or 1.0
        shifted.reshape(-1)[:: len(shifted) + 1] += CONVEXITY_TOLERANCE * size * len(shifted)
        if lapack.dpotrf(shifted)[1]:
            lowest = float(np.linalg.eigvalsh(self.hessian)[0])
            raise InputError(
                "ContactQPCC.hessian must be positive semidefinite, "
                f"its smallest eigenvalue is {lowest:.3g}"
            )

    def _check_squares(self) -> None:
        """Refuse a Q that is not ``diag(d, 0) + N'N`` with d >= 0, and so semidefinite."""
        size = float(self.hessian.diagonal().max())
        rest = self.squares.T @ self.squares
        rest -= self.hessian
        rest.reshape(-1)[: self.control_count * (len(rest) + 1) : len(rest) + 1] = 0.0
        worst = max(float(rest.max()), -float(rest.min()), -float(self.diagonal.min()))
        if worst > CONVEXITY_TOLERANCE * size:
            raise InputError(
                "ContactQPCC.hessian must be its squares and a diagonal of controls that is not "
                f"negative, is off by {worst:.3g}"
            )


def step_problem(
    *,
    constant: float,
    friction: FloatArray,
    factors: FloatArray,
    directions: FloatArray,
    **arrays: FloatArray,
) -> ContactQPCC:
    """The problem that a step has made out of checked goals, its squares known.

    Shapes, symmetry and convexity hold by the way it was made. What is not so, because numbers have
    overflowed or factors are no factors, goes through the constructor, which names it.
    """
    whole = sum(float(np.add.reduce(array, axis=None)) for array in arrays.values())
    positive = not factors.size or np.minimum.reduce(factors, axis=None) > 0.0
    if not (positive and arrays["squares"].size and math.isfinite(whole + constant)):
        held = {"friction": friction, "factors": factors, "directions": directions}
        return ContactQPCC(constant=constant, **held, **arrays)
    held = arrays | {"friction": friction, "directions": directions}
    held["factors"] = factors.reshape(len(friction), len(directions))
    held = {name: np.ascontiguousarray(array) for name, array in held.items()}
    for array in held.values():
        array.setflags(write=False)
    return unchecked(ContactQPCC, constant=constant, **held)


def _check_symmetric(name: str, matrix: FloatArray, tolerance: float) -> None:
    size = max(float(matrix.max(initial=0.0)), -float(matrix.min(initial=0.0)))
    # Both signs of every difference are among them.
    if float((matrix - matrix.T).max(initial=0.0)) > tolerance * size:
        raise InputError(f"ContactQPCC.{name} must be symmetric")


@lru_cache(maxsize=8)
def _check_directions(stored: bytes) -> None:
    """Refuse wrong directions; the answer is kept, as all steps share their directions."""
    directions = np.frombuffer(stored).reshape(-1, 2)
    following = np.roll(directions, -1, axis=0)
    turn = directions[:, 0] * following[:, 1] - directions[:, 1] * following[:, 0]
    unit = np.abs(np.linalg.norm(directions, axis=1) - 1.0) < 1e-9
    if len(directions) < 3 or not np.all(unit) or np.any(turn <= 1e-9):
        raise InputError(
            "ContactQPCC.directions must be three or more unit vectors ordered by angle, "
            "with less than half a turn between neighbours"
        )
    angles = np.arctan2(turn, np.sum(directions * following, axis=1))
    if abs(float(np.sum(angles)) - 2.0 * np.pi) > 1e-6:
        raise InputError("ContactQPCC.directions must go round the tangent plane exactly once")
