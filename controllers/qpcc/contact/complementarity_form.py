"""A contact problem with every complementarity pair written out, as a QPCC in general form.

Residuals are checked on it, apart from contact modes and their cones.

Variables ``x = (u, per contact: f_n, beta_1..beta_m, lam)``; pairs ``0 <= L x + l0 _|_ R x + r0
>= 0`` in the order (f_n, w_n), (beta_j, d_j . w_t + lam), (lam, mu f_n - sum_j beta_j) of
docs/method.md, section 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import BoolArray, FloatArray
from warp_softbody.controllers.qpcc.contact.problem import ContactQPCC
from warp_softbody.controllers.qpcc.general.problem import QPCC
from warp_softbody.inputs import array_checks, checks
from warp_softbody.inputs.records import Value

IntArray = npt.NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FullForm(Value):
    """The arrays of a general QPCC, named as in the literature, with the scales of its pairs.

    Attributes:
        Q: (n, n) with n = nu + K (m + 2).
        c: (n,).
        c0: constant.
        lb: (n,), -inf for every contact variable (the pairs bound them).
        ub: (n,).
        L: (p, n) with p = K (m + 2).
        l0: (p,).
        R: (p, n).
        r0: (p,).
        left_scale: (p,), a typical size of ``L x + l0``, N s or m/s.
        right_scale: (p,), a typical size of ``R x + r0``.
    """

    Q: FloatArray
    c: FloatArray
    c0: float
    lb: FloatArray
    ub: FloatArray
    L: FloatArray
    l0: FloatArray
    R: FloatArray
    r0: FloatArray
    left_scale: FloatArray
    right_scale: FloatArray

    def complementarity(self, x: FloatArray) -> float:
        """Largest ``|min(left, right)|`` over the pairs, both sides divided by their scale."""
        left = (self.L @ x + self.l0) / self.left_scale
        right = (self.R @ x + self.r0) / self.right_scale
        return float(np.max(np.abs(np.minimum(left, right)), initial=0.0))


def force_map(problem: ContactQPCC) -> FloatArray:
    """The map (nu + 3K, nu + K (m + 2)) from x to z = (u, f), ``f_t = sum_j S_j beta_j d_j``."""
    nu, k, m = problem.control_count, problem.contact_count, len(problem.directions)
    out = np.zeros((nu + 3 * k, nu + k * (m + 2)))
    out[:nu, :nu] = np.eye(nu)
    for i in range(k):
        row, column = nu + 3 * i, nu + (m + 2) * i
        out[row, column] = 1.0
        out[row + 1 : row + 3, column + 1 : column + 1 + m] = (
            problem.directions * problem.factors[i][:, None]
        ).T
    return out


def to_full(problem: ContactQPCC) -> FullForm:
    """The problem in general form, with the scales of its pairs."""
    checks.instance("problem of to_full", problem, ContactQPCC)
    nu, k, m = problem.control_count, problem.contact_count, len(problem.directions)
    to_z = force_map(problem)
    size = nu + k * (m + 2)
    left = np.zeros((k * (m + 2), size))
    left[:, nu:] = np.eye(k * (m + 2))
    slopes = np.hstack([problem.velocity_from_controls, problem.velocity_from_forces]) @ to_z
    right, right_offset = np.zeros_like(left), np.zeros(len(left))
    for i in range(k):
        row, column = (m + 2) * i, nu + (m + 2) * i
        right[row] = slopes[3 * i]
        right_offset[row] = problem.velocity_offset[3 * i]
        tangent = slice(3 * i + 1, 3 * i + 3)
        right[row + 1 : row + 1 + m] = problem.directions @ slopes[tangent]
        right[row + 1 : row + 1 + m, column + m + 1] += 1.0
        right_offset[row + 1 : row + 1 + m] = problem.directions @ problem.velocity_offset[tangent]
        right[row + m + 1, column] = problem.friction[i]
        right[row + m + 1, column + 1 : column + 1 + m] = -1.0
    speed, impulse = problem.scales
    left_scale = np.tile(np.r_[np.full(m + 1, impulse), speed], k)
    right_scale = np.tile(np.r_[np.full(m + 1, speed), impulse], k)
    free = np.full(k * (m + 2), np.inf)
    return FullForm(
        Q=to_z.T @ problem.hessian @ to_z,
        c=to_z.T @ problem.gradient,
        c0=problem.constant,
        lb=np.concatenate([problem.lower, -free]),
        ub=np.concatenate([problem.upper, free]),
        L=left,
        l0=np.zeros(len(left)),
        R=right,
        r0=right_offset,
        left_scale=left_scale,
        right_scale=right_scale,
    )


def to_general(problem: ContactQPCC, size: FloatArray | None = None) -> QPCC:
    """The problem in general form, over the variables ``x / size``; size (n,) is one by default."""
    checks.instance("problem of to_general", problem, ContactQPCC)
    full = to_full(problem)
    size = np.ones_like(full.c) if size is None else size
    size = array_checks.array("size of to_general", size, full.c.shape)
    if (size <= 0.0).any():
        checks.refuse("size of to_general", "positive", size)
    return QPCC(
        Q=full.Q * size[:, None] * size,
        c=full.c * size,
        c0=full.c0,
        lb=full.lb / size,
        ub=full.ub / size,
        L=full.L * size,
        l0=full.l0,
        R=full.R * size,
        r0=full.r0,
    )


def full_point(problem: ContactQPCC, controls: FloatArray, forces: FloatArray) -> FloatArray:
    """The x of the full form for given controls and forces (K, 3).

    lam is the largest speed against any direction. The betas are a smallest nonnegative combination
    of two directions that gives the tangent force: sliding forces have one such combination,
    sticking forces inside the cone have one with ``sum beta <= mu f_n``.
    """
    velocities = problem.velocity(controls, forces)
    lam = (-velocities[:, 1:] @ problem.directions.T).max(axis=1, initial=0.0)
    sliding = lam > 1e-9 * problem.scales[0]
    beta = _split_tangents(forces[:, 1:], problem.directions, problem.factors, sliding)
    blocks = np.concatenate([forces[:, :1], beta, lam[:, None]], axis=1)
    return np.concatenate([controls, blocks.reshape(-1)])


def complementarity(problem: ContactQPCC, controls: FloatArray, forces: FloatArray) -> float:
    """The largest scaled residual of a pair, as ``to_full(..).complementarity(full_point(..))``.

    It takes less time: no matrix is put together.
    """
    velocities = problem.velocity(controls, forces)
    return scaled_residual(problem, full_point(problem, controls, forces), velocities)


def scaled_residual(problem: ContactQPCC, x: FloatArray, velocities: FloatArray) -> float:
    """The same for a point ``x`` of the full form whose contact velocities (K, 3) are known."""
    speed, impulse = problem.scales
    blocks = x[problem.control_count :]
    blocks = blocks.reshape(problem.contact_count, len(problem.directions) + 2)
    normal, beta, lam = blocks[:, :1], blocks[:, 1:-1], blocks[:, -1:]
    against = velocities[:, 1:] @ problem.directions.T + lam
    spare = problem.friction[:, None] * normal - beta.sum(axis=1, keepdims=True)
    left = np.concatenate([normal / impulse, beta / impulse, lam / speed], axis=1)
    right = np.concatenate([velocities[:, :1] / speed, against / speed, spare / impulse], axis=1)
    return float(np.abs(np.minimum(left, right)).max(initial=0.0))


class _DirectionPairs(NamedTuple):
    """All P pairs of tangent directions.

    ``inverse`` (2P, 2) gives the two coefficients of a tangent vector, first those of every pair's
    first direction; ``usable`` (P,) are the pairs that span the plane, ``neighbours`` (P,) those of
    them that lie side by side.
    """

    first: IntArray
    second: IntArray
    inverse: FloatArray
    usable: BoolArray
    neighbours: BoolArray


@lru_cache(maxsize=8)
def _direction_pairs(directions: bytes) -> _DirectionPairs:
    plane = np.frombuffer(directions).reshape(-1, 2)
    count = len(plane)
    first, second = np.triu_indices(count, 1)
    a, b = plane[first], plane[second]
    determinant = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    usable = np.abs(determinant) > 1e-12
    inverse = np.stack([b[:, 1], -b[:, 0], -a[:, 1], a[:, 0]], axis=-1)
    inverse /= np.where(usable, determinant, 1.0)[:, None]
    inverse = inverse.reshape(-1, 2, 2).swapaxes(0, 1).reshape(-1, 2)
    apart = second - first
    beside = usable & ((apart == 1) | (apart == count - 1))
    return _DirectionPairs(first, second, inverse, usable, beside)


def _split_tangents(
    tangents: FloatArray, directions: FloatArray, scale: FloatArray, neighbours: BoolArray
) -> FloatArray:
    """(K, m) beta >= 0 with ``sum_j S_j beta_j d_j = tangent``, two each, least in sum.

    A sliding force lies between neighbours; a sticking one may span any two directions, because
    with unequal S some directions lie inside the hull of the others.
    """
    contacts, count = scale.shape
    pairs = _direction_pairs(directions.tobytes())
    betas = (tangents @ pairs.inverse.T).reshape(contacts, 2, len(pairs.first))
    betas[:, 0] /= scale[:, pairs.first]
    betas[:, 1] /= scale[:, pairs.second]
    sizes = np.abs(betas)
    deficit = (sizes - betas).max(axis=1) * 0.5
    slack = 1e-12 * (1.0 + np.abs(tangents).sum(axis=1, keepdims=True))
    cost = np.where(deficit <= slack, 0.0, 1e6 * deficit) + sizes.sum(axis=1)
    usable = np.where(neighbours[:, None], pairs.neighbours, pairs.usable)
    best = np.where(usable, cost, np.inf).argmin(axis=1)
    each, beta = np.arange(contacts), np.zeros((contacts, count))
    beta[each, pairs.first[best]] = betas[each, 0, best]
    beta[each, pairs.second[best]] = betas[each, 1, best]
    return beta
