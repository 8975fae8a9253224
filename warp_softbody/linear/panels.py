"""Solves with a factor by panels of columns that share their rows, on processors."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warp_softbody.device.allocator import constant_integers
from warp_softbody.device.launching import launch
from warp_softbody.device.workspace import WorkPart
from warp_softbody.kernels.linear.supernodes import PanelStructure, make_supernodes
from warp_softbody.kernels.precision import BLOCK, Real
from warp_softbody.linear.supernodes import build_supernodes
from warp_softbody.linear.symbolic_ldlt import Elimination


class PanelLayout:
    """The constant device arrays of a pattern's panels, shared by all factors that have it.

    Attributes:
        structure: struct of what solves need.
        first, below_start, below_slot, owner, panel_start: as in `Supernodes`.
        inner_slot: slots of the blocks within runs, row by row.
        registers: of all panels.
        work_size: numbers that a solve works in.
    """

    def __init__(self, elimination: Elimination, device: str) -> None:
        """Group the columns of a pattern to panels."""
        runs = build_supernodes(elimination)
        count = len(elimination.order)
        rows = list(zip(runs.inner_start, elimination.row_start[1:], strict=True))
        inner_start = np.cumsum([0, *(end - start for start, end in rows)]).astype(np.int32)
        inner = np.concatenate([np.arange(start, end, dtype=np.int32) for start, end in rows])

        def integers(values: npt.NDArray[np.int32]) -> Any:
            return constant_integers(values, wp.int32, device)

        self.first = integers(runs.first)
        self.below_start = integers(runs.below_start)
        self.below_slot = integers(runs.below_slot)
        self.owner = integers(runs.owner)
        self.panel_start = integers(runs.panel_start)
        self.inner_slot = integers(inner)
        self.registers = int(runs.panel_start[-1])
        most = max(end - start for start, end in pairwise(runs.below_start.tolist()))
        # four numbers a node; the rows below a run side by side, and a register behind them
        self.work_size = 4 * count + 3 * most + BLOCK
        at: Any = PanelStructure()
        at.count, at.runs = count, len(runs.first) - 1
        at.order, at.first = integers(elimination.order), self.first
        at.inner_start = integers(inner_start)
        at.below_start, at.below = self.below_start, integers(runs.below)
        at.panel_start = self.panel_start
        self.structure = at


class PanelSolver:
    """Panels of one factor; launches are capturable.

    Attributes:
        kept: device arrays of the factor: panels and the blocks within runs.
    """

    def __init__(
        self, layout: PanelLayout, types: Real, device: str, work: WorkPart, *, half: bool = False
    ) -> None:
        """Panels of zeros, in half precision if wanted; ``work`` has what a solve works in."""
        self._at, self._device = layout, device
        self._kernels = make_supernodes(types.name, half=half)
        count = max(1, layout.registers)
        self._panels = wp.zeros(count, dtype=self._kernels.block, device=device)
        inner = max(1, len(layout.inner_slot))
        self._inner = wp.zeros(inner, dtype=types.mat33, device=device)
        self.kept = (self._panels, self._inner)
        self._work = work.zeros(layout.work_size, types.scalar)

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, dim, inputs, outputs, self._device)

    def pack(self, lower: Any) -> None:
        """Launch the copy of the factor's blocks, (entries,) mat33, to the panels."""
        k, at = self._kernels, self._at
        places = [at.first, at.below_start, at.below_slot, at.owner, at.panel_start]
        self._launch(k.pack, len(at.owner), [*places, lower], [self._panels])
        self._launch(k.pack_inner, len(at.inner_slot), [at.inner_slot, lower], [self._inner])

    def solve(self, pivot_inverse: Any, turns: Any, residual: Any, result: Any) -> None:
        """Launch result = Q (L D L^T)^-1 Q^T residual, vectors (count,) vec3, Q the turns."""
        inputs = [self._at.structure, self._inner, self._panels, pivot_inverse, turns, residual]
        self._launch(self._kernels.precondition, 1, inputs, [self._work, result])
