"""Units in which a general QPCC has coefficients near one, whatever units it was written in.

The logarithms of all scales are chosen by least squares (Curtis and Reid, 1972), here over rows,
variables, objective and the unit of the variables at once. A problem whose rows, variables, unit or
objective were multiplied by any factors is therefore brought back to the same numbers. Scales are
powers of two for the variables, and rows are divided by their largest coefficient.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray

IntArray = npt.NDArray[np.intp]

SWEEPS = 40
"""Most iterations of conjugate gradients on the normal equations of the scales."""

ENOUGH = 1e-2
"""Relative residual of these: scales are rounded to powers of two anyway."""

NEGLIGIBLE = 1e-14
"""Coefficients below this share of their row's largest are taken for rounding."""

BOUND_WEIGHT = 0.25
"""Weight of a bound's size among the equations: some bounds only stand for infinity."""

FARTHEST = 60.0
"""Largest exponent of two of a scale, about 1e18."""


@dataclass(frozen=True)
class RowBlock:
    """Rows (m, n) and their constants (m,), infinite ones meaning none."""

    rows: FloatArray
    constants: FloatArray


@dataclass(frozen=True)
class Equilibration:
    """Scales: ``x = variables * y``, and every row of each block is divided by its scale.

    Attributes:
        variables: (n,).
        blocks: for each block of rows (m,).
        objective: by which the objective is divided.
    """

    variables: FloatArray
    blocks: tuple[FloatArray, ...]
    objective: float


def equilibrate(
    hessian: FloatArray,
    gradient: FloatArray,
    blocks: tuple[RowBlock, ...],
    bounds: tuple[FloatArray, ...],
) -> Equilibration:
    """The scales of a problem; ``bounds`` are arrays (n,), infinite where there is none."""
    variables = np.exp2(_exponents(hessian, gradient, blocks, bounds))
    return row_equilibrated(variables, hessian, gradient, blocks)


def row_equilibrated(
    variables: FloatArray,
    hessian: FloatArray,
    gradient: FloatArray,
    blocks: tuple[RowBlock, ...],
) -> Equilibration:
    """Known scales of the variables, and those of rows and objective that go with them."""
    scaled = [np.abs(block.rows) * variables for block in blocks]
    row_scales = tuple(
        _row_scales(rows, block.constants) for rows, block in zip(scaled, blocks, strict=True)
    )
    curvature = float((np.abs(hessian) * variables[:, None] * variables).max(initial=0.0))
    slope = float((np.abs(gradient) * variables).max(initial=0.0))
    return Equilibration(variables, row_scales, _power(max(curvature, slope) or 1.0))


def _row_scales(rows: FloatArray, constants: FloatArray) -> FloatArray:
    """Largest coefficient of every row, its constant where all are zero, and 1 if that is too."""
    size: FloatArray = rows.max(axis=1, initial=0.0)
    size = np.where(size > 0.0, size, np.abs(np.where(np.isfinite(constants), constants, 0.0)))
    return np.where(size > 0.0, size, 1.0)


def _power(size: float) -> float:
    return float(np.exp2(np.round(np.log2(size))))


class _Equations:
    """Equations ``log2 |coefficient| + sum of signs * scales = 0``, three scales at most in each.

    The scales are those of the variables, of their common unit, of the objective and of all rows.
    """

    def __init__(self, variables: int, rows: int) -> None:
        self.unit, self.objective, self.first_row = variables, variables + 1, variables + 2
        # one more, of no effect, stands where an equation has fewer than three
        self.none = self.first_row + rows
        self._parts: list[tuple[FloatArray, FloatArray, IntArray, FloatArray]] = []

    def add(
        self, sizes: FloatArray, weight: float | FloatArray, *terms: tuple[IntArray | int, float]
    ) -> None:
        """Equations of some coefficients; each term has the numbers of its scales and its sign."""
        if not sizes.size:
            return
        places = np.full((sizes.size, 3), self.none)
        signs = np.zeros((sizes.size, 3))
        for column, (place, sign) in enumerate(terms):
            places[:, column] = place
            signs[:, column] = sign
        weights = np.broadcast_to(np.asarray(weight, np.float64), sizes.shape)
        self._parts.append((np.log2(sizes), weights, places, signs))

    def solve(self) -> FloatArray:
        """The scales' logarithms, by conjugate gradients with the diagonal as preconditioner."""
        if not self._parts:
            return np.zeros(self.none + 1)
        sizes = np.concatenate([part[0] for part in self._parts])
        weights = np.concatenate([part[1] for part in self._parts])
        places = np.concatenate([part[2] for part in self._parts])
        signs = np.concatenate([part[3] for part in self._parts])
        flat = places.reshape(-1)

        def gather(values: FloatArray) -> FloatArray:
            weighted = (weights * values)[:, None] * signs
            sums = np.bincount(flat, weighted.reshape(-1), self.none + 1)
            return np.asarray(sums, np.float64)

        diagonal = np.bincount(flat, (weights[:, None] * np.abs(signs)).reshape(-1), self.none + 1)
        inverse = 1.0 / np.where(diagonal > 0.0, diagonal, 1.0)
        x = np.zeros(self.none + 1)
        residual = gather(-sizes)
        step = inverse * residual
        size = float(residual @ step)
        enough = ENOUGH**2 * size
        for _ in range(SWEEPS):
            if size <= enough:
                break
            image = gather((step[places] * signs).sum(axis=1))
            length = size / float(step @ image)
            x += length * step
            residual -= length * image
            before, size = size, float(residual @ (inverse * residual))
            step = inverse * residual + (size / before) * step
        return x


def _exponents(
    hessian: FloatArray,
    gradient: FloatArray,
    blocks: tuple[RowBlock, ...],
    bounds: tuple[FloatArray, ...],
) -> FloatArray:
    """Whole exponents of two of the variables' scales, (n,)."""
    count = len(gradient)
    equations = _Equations(count, sum(len(block.rows) for block in blocks))
    row = equations.first_row
    for block in blocks:
        rows = np.abs(block.rows)
        i, j = np.nonzero(rows > NEGLIGIBLE * rows.max(axis=1, initial=0.0, keepdims=True))
        equations.add(rows[i, j], 1.0, (row + i, -1.0), (j, 1.0))
        i = np.flatnonzero(np.isfinite(block.constants) & (block.constants != 0.0))
        constants = np.abs(block.constants[i])
        equations.add(constants, 1.0, (row + i, -1.0), (equations.unit, 1.0))
        row += len(rows)
    for bound in bounds:
        i = np.flatnonzero(np.isfinite(bound) & (bound != 0.0))
        equations.add(np.abs(bound[i]), BOUND_WEIGHT, (i, -1.0), (equations.unit, 1.0))
    sizes = np.abs(hessian)
    curved = sizes > NEGLIGIBLE * np.sqrt(np.outer(sizes.diagonal(), sizes.diagonal()))
    i, j = np.nonzero(curved & (sizes > 0.0))
    entries = np.maximum(np.bincount(i, minlength=count), 1)
    weight = 1.0 / np.sqrt(entries[i] * entries[j])
    equations.add(sizes[i, j], weight, (i, 1.0), (j, 1.0), (equations.objective, -1.0))
    i = np.flatnonzero(gradient)
    terms = ((i, 1.0), (equations.unit, 1.0), (equations.objective, -1.0))
    equations.add(np.abs(gradient[i]), 1.0, *terms)
    scales = equations.solve()
    exponents: FloatArray = np.round(scales[:count] - scales[equations.unit])
    return np.clip(exponents, -FARTHEST, FARTHEST)
