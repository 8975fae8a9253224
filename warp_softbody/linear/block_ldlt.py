"""A sparse block L D L^T factor on the device."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.device.allocator import Allocator, constant_integers
from warp_softbody.device.launching import launch
from warp_softbody.device.workspace import Workspace
from warp_softbody.kernels.linear.block_lanes import lanes_on
from warp_softbody.kernels.linear.ldlt_factor import make_factorisation
from warp_softbody.kernels.linear.warped_ldlt import make_cholesky
from warp_softbody.kernels.precision import Real
from warp_softbody.linear.panels import PanelLayout, PanelSolver
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
    """

    def __init__(self, elimination: Elimination, device: str) -> None:
        """Put a pattern on a device."""
        self._elimination, self._device = elimination, device
        self.count = len(elimination.order)
        self.entries = len(elimination.column)
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

    @cached_property
    def panels(self) -> PanelLayout:
        """The columns grouped to panels."""
        return PanelLayout(self._elimination, self._device)


_STRUCTURES: WeakKeyDictionary[Elimination, dict[str, FactorStructure]] = WeakKeyDictionary()
"""By pattern and device, for as long as somebody has the pattern."""


def structure_of(elimination: Elimination, device: str) -> FactorStructure:
    """The arrays of a pattern on a device, made once."""
    of_devices = _STRUCTURES.setdefault(elimination, {})
    if device not in of_devices:
        of_devices[device] = FactorStructure(elimination, device)
    return of_devices[device]


Served = Literal["vectors", "blocks", "both"]
"""The right-hand sides that a factor solves for: one at a time, or 16 side by side."""


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
        serves: Served = "both",
        half: bool = False,
    ) -> None:
        """Arrays for the factor, not yet computed.

        Args:
            elimination: the pattern.
            types: of the precision.
            device: name of the Warp device.
            margin: part of a pivot that is added to it.
            native_code: whether to use native code for processors where there is some.
            workspace: of the arrays of a factorisation on its way.
            serves: what it is to solve for; what others would need is not kept.
            half: whether `solve` rounds L to half precision, where it is native code.
        """
        work = (workspace or Workspace()).part("factorisation", Allocator(types, device))
        self._margin = margin
        self._device = device
        self._at = at = structure_of(elimination, device)
        lanes = lanes_on(device, types.name) if native_code else None
        self._blocks = lanes or make_cholesky(types.name)
        self._factorisation = make_factorisation(types.name)
        self._panels: PanelSolver | None = None
        if lanes is not None and serves != "blocks":
            self._panels = PanelSolver(at.panels, types, device, work, half=half)
        only_packed = self._panels is not None and serves == "vectors"
        keep = work.zeros if only_packed else Allocator(types, device).zeros
        self.lower = keep(at.entries, types.mat33)
        self.pivot_inverse = wp.zeros(at.count, dtype=types.mat33, device=device)
        self._kept = () if only_packed else (self.lower,)
        self._upper, self._turned = (
            work.zeros(at.entries, self._factorisation.mat34) for _ in range(2)
        )
        self._waiting = work.zeros(at.count, self._factorisation.mat34)
        self._pivots = work.zeros(at.count, types.mat33)
        self._plain = make_cholesky(types.name).precondition
        self._work = work.zeros(0 if self._panels else at.count, types.vec3)

    @property
    def kept(self) -> tuple[Any, ...]:
        """Device arrays of the factor itself."""
        panels = () if self._panels is None else self._panels.kept
        return (*self._kept, self.pivot_inverse, *panels)

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
        if self._panels is not None:
            self._panels.pack(self.lower)

    def solve(self, turns: Any, residual: Any, result: Any) -> None:
        """Launch result = Q (L D L^T)^-1 Q^T residual, vectors (count,) vec3, Q the turns."""
        if self._panels is not None:
            self._panels.solve(self.pivot_inverse, turns, residual, result)
            return
        at = self._at
        inputs = [at.count, at.order, at.row_start, at.column]
        inputs += [self.lower, self.pivot_inverse, turns, residual]
        self._launch(self._plain, 1, inputs, [self._work, result])

    def solve_block(self, turns: Any, residual: Any, work: Any, result: Any) -> None:
        """Launch the same for blocks (blocks, 3 count)."""
        at = self._at
        structure = [at.count, at.order, at.row_start, at.column]
        inputs = [*structure, self.lower, self.pivot_inverse, turns, residual]
        blocks = residual.shape[0]
        self._launch(self._blocks.precondition_block, blocks, inputs, [work, result])
