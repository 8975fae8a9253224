"""Random QPCCs of many kinds, and the same ones in other units, to try verdicts and values on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc import QPCC

KINDS = ("monotone", "free", "linear", "bilevel", "infeasible", "unbounded", "idle", "thin")
"""What ``random_problem`` makes; ``kind`` of a number is that number modulo their count."""

SCALINGS = ("none", "variables", "rows", "unit", "objective", "all")
"""What ``rescaled`` multiplies by powers of ten from -6 to 6."""


@dataclass(frozen=True)
class ScaledCase:
    """A problem, the same in other units, and by what the objective of the second is larger.

    Attributes:
        name: kind, number and scaling.
        plain: in units in which numbers are near one.
        scaled: the same problem.
        factor: objective of ``scaled`` over that of ``plain``.
    """

    name: str
    plain: QPCC
    scaled: QPCC
    factor: float


def cases(count: int, seed: int = 0) -> list[ScaledCase]:
    """That many random problems, all kinds under all scalings."""
    found = []
    for number in range(count):
        kind = KINDS[number % len(KINDS)]
        scaling = SCALINGS[(number // len(KINDS)) % len(SCALINGS)]
        rng = np.random.default_rng([seed, number])
        plain = random_problem(kind, rng)
        scaled, factor = rescaled(plain, scaling, rng)
        found.append(ScaledCase(f"{kind} {number} {scaling}", plain, scaled, factor))
    return found


def random_problem(kind: str, rng: np.random.Generator) -> QPCC:
    """One problem of 2 to 12 variables and 1 to 8 pairs."""
    n, p = int(rng.integers(1, 7)), int(rng.integers(1, 9))
    if kind == "monotone":
        return _with_lower_level(rng, n, p, symmetric=True)
    if kind == "bilevel":
        return _with_lower_level(rng, n, p, symmetric=False)
    if kind == "linear":
        plain = _with_lower_level(rng, n, p, symmetric=True)
        return _made(_parts(plain) | {"Q": np.zeros_like(plain.Q)})
    if kind == "free":
        return _free(rng, n + p, p)
    if kind == "infeasible":
        return _infeasible(rng, n, p)
    if kind == "unbounded":
        return _unbounded(rng, n, p)
    if kind == "idle":
        return _idle(rng, n, p)
    return _thin(rng, n, p)


def rescaled(plain: QPCC, scaling: str, rng: np.random.Generator) -> tuple[QPCC, float]:
    """The same problem in other units, and its objective over that of the plain one."""
    parts, factor = _parts(plain), 1.0
    n = plain.variable_count
    if scaling in ("variables", "all"):
        half = 10.0 ** rng.integers(-6, 7) if rng.random() < 0.5 else 10.0 ** rng.uniform(-6, 6, n)
        size = np.where(rng.random(n) < 0.5, half, 1.0)
        for name in "AGLR":
            parts[name] = parts[name] / size
        parts["Q"] = parts["Q"] / size / size[:, None]
        parts["c"] = parts["c"] / size
        parts["lb"], parts["ub"] = parts["lb"] * size, parts["ub"] * size
    if scaling in ("rows", "all"):
        for name, side in (("A", "b"), ("G", "h"), ("L", "l0"), ("R", "r0")):
            size = 10.0 ** rng.uniform(-6, 6, len(parts[side]))
            parts[name] = parts[name] * size[:, None]
            parts[side] = parts[side] * size
    if scaling in ("unit", "all"):
        unit = 10.0 ** float(rng.choice([-6, -3, 3, 6]))
        for name in ("b", "h", "l0", "r0", "lb", "ub"):
            parts[name] = parts[name] * unit
        parts["c"] = parts["c"] * unit
        factor *= unit**2
    if scaling in ("objective", "all"):
        size = 10.0 ** float(rng.choice([-6, -3, 3, 6]))
        parts["Q"], parts["c"] = parts["Q"] * size, parts["c"] * size
        factor *= size
    return _made(parts), factor


def _made(parts: dict[str, FloatArray]) -> QPCC:
    values: dict[str, Any] = {**parts}
    return QPCC(**values)


def _parts(problem: QPCC) -> dict[str, FloatArray]:
    return {
        name: np.array(getattr(problem, name)) for name in QPCC.array_names() if name != "h_lower"
    }


def _hessian(rng: np.random.Generator, size: int) -> FloatArray:
    rank = int(rng.integers(1, size + 1))
    factor = rng.normal(size=(rank, size))
    hessian: FloatArray = factor.T @ factor / rank
    return hessian


def _with_lower_level(rng: np.random.Generator, n: int, p: int, *, symmetric: bool) -> QPCC:
    """Upper variables in a box, lower ones by a monotone complementarity system: always a point."""
    lower = rng.normal(size=(p, int(rng.integers(1, p + 1))))
    matrix = lower @ lower.T / p + 0.1 * np.eye(p)
    if not symmetric:
        skew = rng.normal(size=(p, p))
        matrix += skew - skew.T
    return QPCC(
        Q=_hessian(rng, n + p),
        c=rng.normal(size=n + p),
        lb=np.r_[np.full(n, -1.0), np.full(p, -np.inf)],
        ub=np.r_[np.full(n, 1.0), np.full(p, np.inf)],
        L=np.hstack([np.zeros((p, n)), np.eye(p)]),
        l0=np.zeros(p),
        R=np.hstack([rng.normal(size=(p, n)), matrix]),
        r0=rng.normal(size=p),
    )


def _free(rng: np.random.Generator, n: int, p: int) -> QPCC:
    """Pairs, equations and inequalities through a random point; a definite objective."""
    point = rng.normal(size=n)
    left, right = rng.normal(size=(2, p, n))
    zero = rng.random(p) < 0.5
    spare = rng.uniform(0.0, 1.0, size=p)
    equations, rows = int(rng.integers(0, 2)), int(rng.integers(0, 4))
    along, above = rng.normal(size=(equations, n)), rng.normal(size=(rows, n))
    return QPCC(
        Q=_hessian(rng, n) + 0.1 * np.eye(n),
        c=rng.normal(size=n),
        A=along,
        b=along @ point,
        G=above,
        h=above @ point + rng.uniform(0.0, 1.0, size=rows),
        L=left,
        l0=np.where(zero, 0.0, spare) - left @ point,
        R=right,
        r0=np.where(zero, spare, 0.0) - right @ point,
    )


def _infeasible(rng: np.random.Generator, n: int, p: int) -> QPCC:
    """As the monotone ones, but all sides of one pair shall be at least a half by further rows."""
    parts = _parts(_with_lower_level(rng, n, p, symmetric=True))
    pair = int(rng.integers(p))
    rows = -np.stack([parts["L"][pair], parts["R"][pair]])
    sides = np.array([parts["l0"][pair], parts["r0"][pair]])
    return _made(parts | {"G": rows, "h": sides - rng.uniform(0.05, 1.0, size=2)})


def _unbounded(rng: np.random.Generator, n: int, p: int) -> QPCC:
    """One more variable, in no row, that the objective does not curve but tilts."""
    parts = _parts(_with_lower_level(rng, n, p, symmetric=True))
    for name in "AGLR":
        parts[name] = np.hstack([parts[name], np.zeros((len(parts[name]), 1))])
    size = n + p + 1
    hessian = np.zeros((size, size))
    hessian[:-1, :-1] = parts["Q"]
    tilt = float(rng.choice([-1.0, -1e-3, -1e-6, -1e-9]))
    return _made(
        parts
        | {
            "Q": hessian,
            "c": np.r_[parts["c"], tilt],
            "lb": np.r_[parts["lb"], 0.0],
            "ub": np.r_[parts["ub"], np.inf],
        }
    )


def _idle(rng: np.random.Generator, n: int, p: int) -> QPCC:
    """Rows of zeros, pairs that are always closed, and a steep objective."""
    parts = _parts(_free(rng, n + p, p))
    for name in "GLR":
        parts[name] = np.vstack([parts[name], np.zeros((1, n + p))])
    sides = {"h": 1.0, "l0": 1.0, "r0": 0.0}
    for name, value in sides.items():
        parts[name] = np.append(parts[name], value)
    return _made(parts | {"c": parts["c"] * 10.0 ** float(rng.integers(0, 5))})


def _thin(rng: np.random.Generator, n: int, p: int) -> QPCC:
    """Curvature far smaller than the slopes, or zero but for bounds."""
    parts = _parts(_with_lower_level(rng, n, p, symmetric=True))
    small = 10.0 ** rng.uniform(-9, -3)
    return _made(parts | {"Q": small * (parts["Q"] + np.eye(n + p))})
