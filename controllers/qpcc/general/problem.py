"""The general form of a quadratic program with complementarity constraints (QPCC).

    minimise 1/2 x'Qx + c'x + c0
    subject to A x = b,  h_lower <= G x <= h,  lb <= x <= ub,
               0 <= L x + l0  _|_  R x + r0 >= 0

The control problem of a step, equation 11 of docs/method.md, is one instance, which
``contact.complementarity_form.to_general`` writes out.
"""

from __future__ import annotations

import os
from dataclasses import InitVar, dataclass, field, fields
from functools import cached_property

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.qpcc.general.equilibration import (
    Equilibration,
    RowBlock,
    equilibrate,
    row_equilibrated,
)
from warp_softbody.controllers.qpcc.general.problem_arrays import (
    check_numbers,
    check_shapes,
    given_array,
    read_arrays,
    write_arrays,
)
from warp_softbody.errors import InputError
from warp_softbody.inputs import checks
from warp_softbody.inputs.records import FrozenValue


def _absent() -> FloatArray:
    """The default of rows and bounds that a problem does not have."""
    return np.zeros(0)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class QPCC(FrozenValue):
    """A QPCC in general form; arrays are kept as read-only float64 copies.

    Matrices may be given as arrays, lists, or sparse matrices of SciPy.

    Attributes:
        Q: (n, n) symmetric; need not be definite, nor semidefinite (then answers are local).
        c: (n,).
        c0: constant.
        A: (e, n); default no equations.
        b: (e,).
        G: (g, n); default no inequalities.
        h: (g,), may hold +inf.
        h_lower: (g,), may hold -inf; default no lower sides.
        lb: (n,), may hold -inf; default no bounds.
        ub: (n,), may hold +inf.
        L: (p, n), left sides of the pairs; default no pairs.
        l0: (p,), default zero.
        R: (p, n), right sides.
        r0: (p,), default zero.

    Args:
        P: another name of Q, as QP solvers have it.
        q: another name of c.
    """

    Q: FloatArray = field(default_factory=_absent)
    c: FloatArray = field(default_factory=_absent)
    c0: float = 0.0
    A: FloatArray = field(default_factory=_absent)
    b: FloatArray = field(default_factory=_absent)
    G: FloatArray = field(default_factory=_absent)
    h: FloatArray = field(default_factory=_absent)
    h_lower: FloatArray = field(default_factory=_absent)
    lb: FloatArray = field(default_factory=_absent)
    ub: FloatArray = field(default_factory=_absent)
    L: FloatArray = field(default_factory=_absent)
    l0: FloatArray = field(default_factory=_absent)
    R: FloatArray = field(default_factory=_absent)
    r0: FloatArray = field(default_factory=_absent)
    P: InitVar[FloatArray | None] = None
    q: InitVar[FloatArray | None] = None

    def __post_init__(self, P: FloatArray | None, q: FloatArray | None) -> None:
        """Fill in what is left out, convert, then check shapes and numbers."""
        for name, other, value in (("Q", "P", P), ("c", "q", q)):
            if value is not None:
                if given_array("QPCC", name, getattr(self, name)).size:
                    raise InputError(f"QPCC takes {name} or {other}, not both: they are the same")
                checks.keep(self, **{name: given_array("QPCC", other, value)})
        arrays = {
            name: given_array("QPCC", name, getattr(self, name)) for name in self.array_names()
        }
        count = arrays["c"].size
        if count == 0:
            raise InputError("QPCC.c must hold one number per variable, not none")
        if arrays["Q"].size == 0:
            raise InputError("QPCC.Q must hold a number for each two variables, not none")
        # A number in place of a matrix is refused with the shapes, below.
        rows, pairs = (arrays[name].shape[0] if arrays[name].ndim else 0 for name in "GL")
        missing = {
            **{name: np.zeros((0, count)) for name in "AGLR"},
            "lb": np.full(count, -np.inf),
            "ub": np.full(count, np.inf),
            "h": np.full(rows, np.inf),
            "h_lower": np.full(rows, -np.inf),
            "l0": np.zeros(pairs),
            "r0": np.zeros(pairs),
        }
        for name, given in arrays.items():
            array = missing[name] if name in missing and given.size == 0 else given
            array.setflags(write=False)
            checks.keep(self, **{name: array})
        checks.keep(self, c0=checks.number("QPCC.c0", self.c0, low=-1e300, high=1e300))
        held = {name: getattr(self, name) for name in self.array_names()}
        check_shapes(held)
        check_numbers(held)

    @classmethod
    def array_names(cls) -> tuple[str, ...]:
        """Names of all arrays."""
        return tuple(entry.name for entry in fields(cls) if entry.name != "c0")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> QPCC:
        """Read the arrays of an ``.npz`` file by name; others in the file are left alone."""
        values = read_arrays("QPCC", path, (*cls.array_names(), "c0"), needed=("Q", "c"))
        try:
            return cls(**values)
        except InputError as error:
            raise InputError(f"{os.fspath(path)}: {error}") from error

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all arrays into an ``.npz`` file, which ``load`` reads; whole or not at all."""
        held = {name: getattr(self, name) for name in (*self.array_names(), "c0")}
        write_arrays("QPCC", path, held)

    @property
    def variable_count(self) -> int:
        """Number of variables, n."""
        return self.c.size

    @property
    def pair_count(self) -> int:
        """Number of complementarity pairs, p."""
        return self.l0.size

    @cached_property
    def equilibration(self) -> Equilibration:
        """Scales of variables, objective, and the rows of A, G, L and R, in this order."""
        return equilibrate(self.Q, self.c, self._blocks, (self.lb, self.ub))

    def with_own_units(self) -> Equilibration:
        """The same where the variables are in good units already: these are kept."""
        return row_equilibrated(np.ones_like(self.c), self.Q, self.c, self._blocks)

    @property
    def _blocks(self) -> tuple[RowBlock, ...]:
        heights = np.where(np.isfinite(self.h), self.h, self.h_lower)
        blocks = ((self.A, self.b), (self.G, heights), (self.L, self.l0), (self.R, self.r0))
        return tuple(RowBlock(matrix, constants) for matrix, constants in blocks)

    def sides(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """``L x + l0`` and ``R x + r0``."""
        left = self.L @ x + self.l0
        right = self.R @ x + self.r0
        return left, right

    def objective(self, x: FloatArray) -> float:
        """``1/2 x'Qx + c'x + c0``."""
        return float(x @ (0.5 * (self.Q @ x) + self.c)) + self.c0

    def complementarity(self, x: FloatArray) -> float:
        """Largest ``|min(left, right)|`` over the pairs, each side divided by its scale.

        That is the one of ``equilibration``, or the size of the side's terms where these are
        larger.
        """
        _, _, over_left, over_right = self.equilibration.blocks
        (left, right), size = self.sides(x), np.abs(x)
        left = left / np.maximum(over_left, np.abs(self.L) @ size)
        right = right / np.maximum(over_right, np.abs(self.R) @ size)
        return float(np.abs(np.minimum(left, right)).max(initial=0.0))

    def feasibility(self, x: FloatArray) -> float:
        """Largest violation of an equation, inequality or bound, divided by its scale as above."""
        over, over_row, _, _ = self.equilibration.blocks
        size = np.abs(x)
        off = np.abs(self.A @ x - self.b) / np.maximum(over, np.abs(self.A) @ size)
        values = self.G @ x
        above = np.maximum(values - self.h, self.h_lower - values)
        above = above / np.maximum(over_row, np.abs(self.G) @ size)
        out = np.maximum(self.lb - x, x - self.ub)
        out = out / np.maximum(self.equilibration.variables, size)
        return max(0.0, *(float(part.max(initial=0.0)) for part in (off, above, out)))
