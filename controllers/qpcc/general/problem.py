"""The general form of a quadratic program with complementarity constraints (QPCC).

    minimise 1/2 x'Qx + c'x + c0
    subject to A x = b,  G x <= h,  lb <= x <= ub,  0 <= L x + l0  _|_  R x + r0 >= 0

The control problem of a step, equation 11 of docs/method.md, is one instance, which
``contact.complementarity_form.to_general`` writes out.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds
from warp_softbody.inputs.records import FrozenValue


def _absent() -> FloatArray:
    """The default of rows and bounds that a problem does not have."""
    return np.zeros(0)


ARRAYS = ("Q", "c", "A", "b", "G", "h", "lb", "ub", "L", "l0", "R", "r0")


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class QPCC(FrozenValue):
    """A QPCC in general form; arrays are kept as read-only float64 copies.

    Attributes:
        Q: (n, n) symmetric; need not be definite, nor semidefinite (then answers are local).
        c: (n,).
        c0: constant.
        A: (e, n); default no equations.
        b: (e,).
        G: (g, n); default no inequalities.
        h: (g,), may hold +inf.
        lb: (n,), may hold -inf; default no bounds.
        ub: (n,), may hold +inf.
        L: (p, n), left sides of the pairs; default no pairs.
        l0: (p,).
        R: (p, n), right sides.
        r0: (p,).
    """

    Q: FloatArray
    c: FloatArray
    c0: float = 0.0
    A: FloatArray = field(default_factory=_absent)
    b: FloatArray = field(default_factory=_absent)
    G: FloatArray = field(default_factory=_absent)
    h: FloatArray = field(default_factory=_absent)
    lb: FloatArray = field(default_factory=_absent)
    ub: FloatArray = field(default_factory=_absent)
    L: FloatArray = field(default_factory=_absent)
    l0: FloatArray = field(default_factory=_absent)
    R: FloatArray = field(default_factory=_absent)
    r0: FloatArray = field(default_factory=_absent)

    def __post_init__(self) -> None:
        """Fill in what is left out, convert, then check shapes and numbers."""
        count = len(array_checks.array("QPCC.c", self.c, (None,), finite=False))
        if count == 0:
            raise InputError("QPCC.c must hold one number per variable, not none")
        missing = {
            "A": np.zeros((0, count)),
            "G": np.zeros((0, count)),
            "L": np.zeros((0, count)),
            "R": np.zeros((0, count)),
            "lb": np.full(count, -np.inf),
            "ub": np.full(count, np.inf),
        }
        for name in ARRAYS:
            given = array_checks.array(f"QPCC.{name}", getattr(self, name), None, finite=False)
            given = np.array(given, np.float64, order="C")
            array = missing[name] if name in missing and given.size == 0 else given
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        checks.keep(self, c0=checks.number("QPCC.c0", self.c0, low=-1e300, high=1e300))
        self._check_shapes(count)
        self._check_numbers()

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> QPCC:
        """Read the arrays of an ``.npz`` file by name; others in the file are left alone."""
        file = input_kinds.path("path of QPCC.load", path)
        try:
            with np.load(file, allow_pickle=False) as data:
                named = {entry.name for entry in fields(cls)} & set(data.files)
                values = {name: data[name] for name in named}
        # a file that is no archive of arrays fails in many ways
        except Exception as error:
            raise InputError(f"cannot read a QPCC from {os.fspath(path)}: {error}") from error
        lacking = {"Q", "c"} - set(values)
        if lacking:
            raise InputError(f"{os.fspath(path)} holds no QPCC: {sorted(lacking)[0]} is missing")
        return cls(**values)

    @property
    def variable_count(self) -> int:
        """Number of variables, n."""
        return self.c.size

    @property
    def pair_count(self) -> int:
        """Number of complementarity pairs, p."""
        return self.l0.size

    @cached_property
    def side_scales(self) -> tuple[FloatArray, FloatArray]:
        """The scales of the rows of (L, l0) and of (R, r0), see ``row_scales``."""
        return row_scales(self.L, self.l0), row_scales(self.R, self.r0)

    def sides(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """``L x + l0`` and ``R x + r0``."""
        left = self.L @ x + self.l0
        right = self.R @ x + self.r0
        return left, right

    def objective(self, x: FloatArray) -> float:
        """``1/2 x'Qx + c'x + c0``."""
        return float(x @ (0.5 * (self.Q @ x) + self.c)) + self.c0

    def complementarity(self, x: FloatArray) -> float:
        """Largest ``|min(left, right)|`` over the pairs, each side divided by its scale."""
        (left, right), (over_left, over_right) = self.sides(x), self.side_scales
        least = np.minimum(left / over_left, right / over_right)
        return float(np.abs(least).max(initial=0.0))

    def feasibility(self, x: FloatArray) -> float:
        """Largest violation of an equation, inequality or bound, rows divided by their scales."""
        equations, rows = self.A, self.G
        off = np.abs(equations @ x - self.b) / row_scales(equations, self.b)
        over = (rows @ x - self.h) / row_scales(rows, self.h)
        out = np.maximum(self.lb - x, x - self.ub)
        return max(0.0, *(float(part.max(initial=0.0)) for part in (off, over, out)))

    def _check_shapes(self, count: int) -> None:
        expected = {"Q": (count, count), "c": (count,), "lb": (count,), "ub": (count,)}
        for rows, offset in (("A", "b"), ("G", "h"), ("L", "l0"), ("R", "r0")):
            expected[rows] = (getattr(self, offset).size, count)
        expected["R"] = expected["L"] = (self.l0.size, count)
        expected["r0"] = (self.l0.size,)
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                given = getattr(self, name).shape
                raise InputError(f"QPCC.{name} must be of shape {shape}, not {given}")

    def _check_numbers(self) -> None:
        for name in ARRAYS:
            array = getattr(self, name)
            wrong = np.isnan(array) if name in ("lb", "ub", "h") else ~np.isfinite(array)
            if np.any(wrong):
                place = tuple(int(i[0]) for i in np.nonzero(wrong))
                raise InputError(
                    f"QPCC.{name} must be finite, but it holds {array[place]} at {place}"
                )
        lower, upper = self.lb, self.ub
        if np.any(lower > upper) or np.any(lower == np.inf) or np.any(upper == -np.inf):
            i = int(np.argmax((lower > upper) | (lower == np.inf) | (upper == -np.inf)))
            raise InputError(
                f"QPCC.lb and ub of variable {i} leave no value: {lower[i]} to {upper[i]}"
            )
        if np.any(self.h == -np.inf):
            raise InputError("QPCC.h must not be -inf")
        size = float(np.abs(self.Q).max())
        if float(np.abs(self.Q - self.Q.T).max()) > 1e-6 * size:
            raise InputError("QPCC.Q must be symmetric")


def row_scales(rows: FloatArray, offset: FloatArray) -> FloatArray:
    """Largest coefficient of every row, its constant where all are zero, and 1 if that is too."""
    size: FloatArray = np.abs(rows).max(axis=1, initial=0.0)
    constant = np.abs(np.where(np.isfinite(offset), offset, 0.0))
    size = np.where(size > 0.0, size, constant)
    return np.where(size > 0.0, size, 1.0)
