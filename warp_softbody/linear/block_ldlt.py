"""A sparse block L D L^T factor on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.device.allocator import constant_integers
from warp_softbody.device.launching import launch
from warp_softbody.kernels.linear.block_lanes import lanes_on
from warp_softbody.kernels.linear.ldlt_factor import make_factorisation
from warp_softbody.kernels.linear.supernodes import PanelStructure, make_supernodes
from warp_softbody.kernels.linear.warped_ldlt import make_cholesky
from warp_softbody.kernels.precision import Real
from warp_softbody.linear.supernodes import build_supernodes
from warp_softbody.linear.symbolic_ldlt import Elimination


@dataclass(frozen=True)
class Freedom:
    """Which velocities contact leaves free; device arrays over nodes.

    Attributes:
        kinds: (n,) int32, values of `VelocityConstraint`.
        axes: (n,) vec3, normal to the plane on which a node slides, or along its line.
        slip_stiffness: (n,) mat33 kg, added to the diagonal blocks.
    """

    kinds: Any
    axes: Any
    slip_stiffness: Any


class BlockFactor:
    """Factorises a matrix of 3 x 3 blocks and solves with the factor; launches are capturable."""

    def __init__(
        self,
        elimination: Elimination,
        types: Real,
        device: str,
        margin: float = 0.0,
        *,
        native_code: bool = True,
    ) -> None:
        """Arrays for the factor, not yet computed; ``margin``: part of a pivot added to it."""
        self._margin = margin
        self._device = device
        self._count = len(elimination.order)
        lanes = lanes_on(device, types.name) if native_code else None
        self._blocks = lanes or make_cholesky(types.name)
        self._factorisation = make_factorisation(types.name)
        entries = len(elimination.column)
        self.lower = wp.zeros(entries, dtype=types.mat33, device=device)
        self.pivot_inverse = wp.zeros(self._count, dtype=types.mat33, device=device)
        self._upper, self._turned = (
            wp.zeros(entries, dtype=self._factorisation.mat34, device=device) for _ in range(2)
        )
        self._pivots = wp.zeros(self._count, dtype=types.mat33, device=device)
        self._panels = make_supernodes(types.name)
        runs = build_supernodes(elimination)
        registers = (runs.panel_start[-1], 3 * len(runs.below))
        self._by_column, self._by_row = (
            wp.zeros(max(1, int(count)), dtype=types.block, device=device) for count in registers
        )
        # the last component takes what the lanes without a row hold
        self._work = wp.zeros(3 * self._count + 1, dtype=types.scalar, device=device)

        def integers(values: npt.NDArray[np.int32], dtype: Any = wp.int32) -> Any:
            return constant_integers(values, dtype, device)

        self._order = integers(elimination.order)
        self._row_start = integers(elimination.row_start)
        rows = np.arange(self._count, dtype=np.int32)
        self._row = integers(np.repeat(rows, np.diff(elimination.row_start)))
        self._column = integers(elimination.column)
        self._matrix_slot = integers(elimination.matrix_slot)
        self._diagonal_slot = integers(elimination.diagonal_slot)
        self._update_start = integers(elimination.update_start)
        self._update_pairs = integers(elimination.update_pairs, wp.vec2i)
        self._below_slot = integers(runs.below_slot)
        self._owner = integers(runs.owner)
        at: Any = PanelStructure()
        at.count, at.runs = self._count, len(runs.panel_start) - 1
        at.order, at.row_start, at.column = self._order, self._row_start, self._column
        at.first, at.inner_start = integers(runs.first), integers(runs.inner_start)
        at.below_start, at.below = integers(runs.below_start), integers(runs.below)
        at.panel_start, at.targets = integers(runs.panel_start), integers(runs.targets)
        self._structure = at

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, dim, inputs, outputs, self._device)

    def factorise(self, values: Any, freedom: Freedom) -> None:
        """Launch the factorisation of a matrix on the velocities left free."""
        k, entries = self._factorisation, len(self._column)
        pivots = [self._order, self._diagonal_slot, self._margin, values]
        pivots += [freedom.kinds, freedom.axes, freedom.slip_stiffness]
        self._launch(k.gather_pivots, self._count, pivots, [self._pivots])
        blocks = [self._row, self._column, self._matrix_slot, self._order, values]
        blocks += [freedom.kinds, freedom.axes]
        self._launch(k.gather_blocks, entries, blocks, [self._upper])
        updates = [self._row_start, self._column, self._update_start, self._update_pairs]
        outputs = [self._upper, self._turned, self.lower, self.pivot_inverse]
        self._launch(k.factorise, 1, [self._count, *updates, self._pivots], outputs)
        at = self._structure
        places = [at.first, at.below_start, self._below_slot, self._owner, at.panel_start]
        panels = [self._by_column, self._by_row]
        self._launch(self._panels.pack, len(self._owner), [*places, self.lower], panels)

    def solve(self, turns: Any, residual: Any, result: Any) -> None:
        """Launch result = Q (L D L^T)^-1 Q^T residual, vectors (count,) vec3, Q the turns."""
        factor = [self.lower, self._by_column, self._by_row, self.pivot_inverse]
        inputs = [self._structure, *factor, turns, residual]
        self._launch(self._panels.precondition, 1, inputs, [self._work, result])

    def solve_block(self, turns: Any, residual: Any, work: Any, result: Any) -> None:
        """Launch the same for blocks (blocks, 3 count)."""
        structure = [self._count, self._order, self._row_start, self._column]
        inputs = [*structure, self.lower, self.pivot_inverse, turns, residual]
        blocks = residual.shape[0]
        self._launch(self._blocks.precondition_block, blocks, inputs, [work, result])
