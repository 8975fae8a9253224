"""A sparse block L D L^T factor on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.device.allocator import Allocator, constant_integers
from warp_softbody.device.launching import launch
from warp_softbody.device.workspace import Workspace
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


class FactorStructure:
    """The constant device arrays of a factor's pattern, shared by all factors that have it.

    Attributes:
        count: rows of blocks.
        entries: blocks below the diagonal.
        order, row, row_start, column, matrix_slot, diagonal_slot, column_start, column_row,
            column_place: as in `Elimination`; ``row`` is that of each block.
        below_slot, owner: as in `Supernodes`.
        panels: struct of what solves with panels need.
        registers: of the panels by column and by row.
    """

    def __init__(self, elimination: Elimination, device: str) -> None:
        """Group the columns of a pattern to panels, and put all on a device."""
        self.count = len(elimination.order)
        self.entries = len(elimination.column)
        runs = build_supernodes(elimination)
        rows = np.arange(self.count, dtype=np.int32)

        def integers(values: npt.NDArray[np.int32]) -> Any:
            return constant_integers(values, wp.int32, device)

        self.order = integers(elimination.order)
        self.row_start = integers(elimination.row_start)
        self.row = integers(np.repeat(rows, np.diff(elimination.row_start)))
        self.column = integers(elimination.column)
        self.matrix_slot = integers(elimination.matrix_slot)
        self.diagonal_slot = integers(elimination.diagonal_slot)
        self.column_start = integers(elimination.column_start)
        self.column_row = integers(elimination.column_row)
        self.column_place = integers(elimination.column_place)
        self.below_slot = integers(runs.below_slot)
        self.owner = integers(runs.owner)
        self.registers = (int(runs.panel_start[-1]), 3 * len(runs.below))
        at: Any = PanelStructure()
        at.count, at.runs = self.count, len(runs.panel_start) - 1
        at.order, at.row_start, at.column = self.order, self.row_start, self.column
        at.first, at.inner_start = integers(runs.first), integers(runs.inner_start)
        at.below_start, at.below = integers(runs.below_start), integers(runs.below)
        at.panel_start, at.targets = integers(runs.panel_start), integers(runs.targets)
        self.panels = at


_STRUCTURES: WeakKeyDictionary[Elimination, dict[str, FactorStructure]] = WeakKeyDictionary()
"""By pattern and device, for as long as somebody has the pattern."""


def structure_of(elimination: Elimination, device: str) -> FactorStructure:
    """The arrays of a pattern on a device, made once."""
    of_devices = _STRUCTURES.setdefault(elimination, {})
    if device not in of_devices:
        of_devices[device] = FactorStructure(elimination, device)
    return of_devices[device]


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
        workspace: Workspace | None = None,
    ) -> None:
        """Arrays for the factor, not yet computed; ``margin``: part of a pivot added to it.

        Those of a factorisation on its way are in a workspace.
        """
        work = (workspace or Workspace()).part("factorisation", Allocator(types, device))
        self._margin = margin
        self._device = device
        self._at = at = structure_of(elimination, device)
        lanes = lanes_on(device, types.name) if native_code else None
        self._blocks = lanes or make_cholesky(types.name)
        self._factorisation = make_factorisation(types.name)
        self.lower = wp.zeros(at.entries, dtype=types.mat33, device=device)
        self.pivot_inverse = wp.zeros(at.count, dtype=types.mat33, device=device)
        self._upper, self._turned = (
            work.zeros(at.entries, self._factorisation.mat34) for _ in range(2)
        )
        self._waiting = work.zeros(at.count, self._factorisation.mat34)
        self._pivots = work.zeros(at.count, types.mat33)
        self._panels = make_supernodes(types.name)
        self._by_column, self._by_row = (
            wp.zeros(max(1, count), dtype=types.block, device=device) for count in at.registers
        )
        # the last component takes what the lanes without a row hold
        self._work = work.zeros(3 * at.count + 1, types.scalar)

    @property
    def kept(self) -> tuple[Any, ...]:
        """Device arrays of the factor itself."""
        return (self.lower, self.pivot_inverse, self._by_column, self._by_row)

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, dim, inputs, outputs, self._device)

    def factorise(self, values: Any, freedom: Freedom) -> None:
        """Launch the factorisation of a matrix on the velocities left free."""
        k, at = self._factorisation, self._at
        pivots = [at.order, at.diagonal_slot, self._margin, values]
        pivots += [freedom.kinds, freedom.axes, freedom.slip_stiffness]
        self._launch(k.gather_pivots, at.count, pivots, [self._pivots])
        blocks = [at.row, at.column, at.matrix_slot, at.order, values]
        blocks += [freedom.kinds, freedom.axes]
        self._launch(k.gather_blocks, at.entries, blocks, [self._upper])
        places = [at.row_start, at.column, at.column_start, at.column_row, at.column_place]
        outputs = [self._upper, self._waiting, self._turned, self.lower, self.pivot_inverse]
        self._launch(k.factorise, 1, [at.count, *places, self._pivots], outputs)
        runs = at.panels
        places = [runs.first, runs.below_start, at.below_slot, at.owner, runs.panel_start]
        panels = [self._by_column, self._by_row]
        self._launch(self._panels.pack, len(at.owner), [*places, self.lower], panels)

    def solve(self, turns: Any, residual: Any, result: Any) -> None:
        """Launch result = Q (L D L^T)^-1 Q^T residual, vectors (count,) vec3, Q the turns."""
        factor = [self.lower, self._by_column, self._by_row, self.pivot_inverse]
        inputs = [self._at.panels, *factor, turns, residual]
        self._launch(self._panels.precondition, 1, inputs, [self._work, result])

    def solve_block(self, turns: Any, residual: Any, work: Any, result: Any) -> None:
        """Launch the same for blocks (blocks, 3 count)."""
        at = self._at
        structure = [at.count, at.order, at.row_start, at.column]
        inputs = [*structure, self.lower, self.pivot_inverse, turns, residual]
        blocks = residual.shape[0]
        self._launch(self._blocks.precondition_block, blocks, inputs, [work, result])
