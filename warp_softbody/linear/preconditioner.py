"""Preconditioners of conjugate gradients: a whole factor, or two levels for large bodies."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.warp_runtime import with_kernels
from warp_softbody.device.workspace import Workspace
from warp_softbody.kernels.linear.sweep_lanes import sweep_lanes_on
from warp_softbody.kernels.linear.two_level import make_two_level
from warp_softbody.kernels.linear.warped_ldlt import make_cholesky
from warp_softbody.linear.block_ldlt import BlockFactor, Freedom, Served
from warp_softbody.linear.held_motions import HeldMotions
from warp_softbody.linear.system import CoarseLevel, LinearSystem

MOST_OF_SINGLE = 20_000
"""Blocks of a coarse factor beyond which its panels, 36 bytes a block, would fill most of a
processor's second-level cache, and are kept in half precision."""


class Preconditioner(Protocol):
    """Symmetric and positive definite on the velocities that contact leaves free."""

    @property
    def renewable(self) -> bool:
        """Whether ``renew`` launches anything."""
        ...

    age: float
    """Iterations that a fresh one would have saved since ``renew``."""

    @property
    def kept(self) -> tuple[Any, ...]:
        """Device arrays that hold what is kept over many steps."""
        ...

    @property
    def stale(self) -> bool:
        """Whether ``renew`` is due."""
        ...

    def renewed(self) -> None:
        """Note that ``renew`` has run on the present matrix."""
        ...

    def used(self, iterations: int, fresh: int, *, converged: bool = True) -> None:
        """Note the iterations of a step, those that it takes at best, and whether they sufficed."""
        ...

    def renew(self, freedom: Freedom) -> None:
        """Launch what is kept over many steps."""
        ...

    def prepare(self, freedom: Freedom) -> None:
        """Launch what every solve needs."""
        ...

    def apply(self, residual: Any, result: Any) -> None:
        """Launch result = P residual, (n,) vec3."""
        ...

    def apply_block(self, residual: Any, work: Any, result: Any) -> None:
        """Launch result = P residual for blocks (blocks, 3n)."""
        ...


def make_preconditioner(
    system: LinearSystem,
    values: Any,
    node_rotations: Any,
    workspace: Workspace,
    serves: Served = "both",
) -> Preconditioner:
    """The preconditioner of the matrix in ``values``: by two levels where there is a coarse one.

    ``serves`` tells what it is applied to, so that a factor keeps no more than that.
    """
    if system.coarse is None:
        return WarpedFactor(system, values, node_rotations, workspace, serves)
    return TwoLevel(system, system.coarse, values, node_rotations)


class WarpedFactor:
    """An L D L^T factor of an earlier matrix, warped by the rotations of the nodes since then.

    It is stale when the iterations that a fresh factor would have saved would have paid for it; a
    count, not a clock, so that runs repeat.
    """

    renewable = True

    def __init__(
        self,
        system: LinearSystem,
        values: Any,
        node_rotations: Any,
        workspace: Workspace,
        serves: Served = "both",
    ) -> None:
        """Arrays for the factor of the matrix in ``values``; nothing is computed yet."""
        types, n = system.types, system.node_count
        self._system = system
        self._values = values
        self._node_rotations = node_rotations
        self._cost = system.elimination.refresh_cost
        self.age = float("inf")
        self._kernels = make_cholesky(types.name)
        self.factor = BlockFactor(
            system.elimination,
            types,
            system.device,
            margin=system.pivot_margin,
            native_code=system.native_code,
            workspace=workspace,
            serves=serves,
        )
        self._factor_rotations = system.zeros(n, types.mat33)
        self._turns = system.zeros(n, types.mat33)

    @property
    def kept(self) -> tuple[Any, ...]:
        """The factor, and the rotations of the nodes that it was made with."""
        return (*self.factor.kept, self._factor_rotations)

    @property
    def stale(self) -> bool:
        """Whether a new factor is due."""
        return self.age > self._cost

    def renewed(self) -> None:
        """Note that the factor is of the present matrix."""
        self.age = 0.0

    def used(self, iterations: int, fresh: int, *, converged: bool = True) -> None:
        """Count iterations beyond those that even a fresh factor would have needed."""
        self.age += max(0, iterations - fresh) if converged else float("inf")

    def renew(self, freedom: Freedom) -> None:
        """Launch the factorisation of the present matrix on the velocities left free."""
        self.factor.factorise(self._values, freedom)
        self._launch(self._kernels.keep_rotations, [self._node_rotations], [self._factor_rotations])

    def prepare(self, freedom: Freedom) -> None:
        """Launch the update of each node's rotation since the factorisation."""
        rotations = [self._node_rotations, self._factor_rotations]
        self._launch(self._kernels.node_turns, rotations, [self._turns])

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        dim, device = self._system.node_count, self._system.device
        launch(kernel, dim, inputs, outputs, device)

    def apply(self, residual: Any, result: Any) -> None:
        """Launch result = P residual, (n,) vec3."""
        self.factor.solve(self._turns, residual, result)

    def apply_block(self, residual: Any, work: Any, result: Any) -> None:
        """Launch result = P residual for blocks (blocks, 3n)."""
        self.factor.solve_block(self._turns, residual, work, result)


class TwoLevel:
    """Gauss-Seidel sweeps around a correction by rigid motions of aggregates.

    The sweeps use the matrix as it is; the coarse matrix is that of the rest shape, turned with the
    nodes, and is factorised once.
    """

    renewable = False
    stale = False
    kept: tuple[Any, ...] = ()

    def __init__(
        self, system: LinearSystem, coarse: CoarseLevel, values: Any, node_rotations: Any
    ) -> None:
        """Factorise the coarse matrix of a system."""
        types, n, size = system.types, system.node_count, coarse.node_count
        self.age = 0.0
        self._system = system
        self._aggregates = coarse.aggregates
        self._values = values
        self._node_rotations = node_rotations
        self._kernels = make_two_level(types.name)
        lanes = sweep_lanes_on(system.device, types.name)
        self._lanes = lanes if system.native_code else None
        self._pivot_inverse = system.zeros(n, types.mat33)
        wide = [system.zeros(n if self._lanes else 0, types.vec4) for _ in range(2)]
        self._swept, self._behind = wide
        self._right = system.zeros(size, types.vec3)
        self._motion = system.zeros(size, types.vec3)
        self._unturned = system.array(np.tile(np.eye(3), (size, 1, 1)), types.mat33)
        self._freedom: Freedom | None = None
        self._block_arrays: dict[int, tuple[Any, Any, Any]] = {}
        many = len(system.elimination.column) > MOST_OF_SINGLE
        self._factor = BlockFactor(
            system.elimination,
            types,
            system.device,
            margin=system.pivot_margin,
            native_code=system.native_code,
            half=many and types.name == "float32",
        )
        free = Freedom(
            system.zeros(size, wp.int32),
            system.zeros(size, types.vec3),
            system.zeros(size, types.mat33),
        )
        matrix = system.array(coarse.values, types.mat33)
        with_kernels(lambda: self._factor.factorise(matrix, free))
        self._held_motions: HeldMotions | None = None
        if coarse.held_margin is not None:
            margin = coarse.held_margin
            self._held_motions = HeldMotions(system, coarse, self._factor, values, margin)

    def renewed(self) -> None:
        """Nothing is kept that could grow stale."""

    def used(self, iterations: int, fresh: int, *, converged: bool = True) -> None:
        """Nothing is kept that could grow stale."""

    def renew(self, freedom: Freedom) -> None:
        """Nothing is kept that could grow stale."""

    def prepare(self, freedom: Freedom) -> None:
        """Launch the inverse diagonal on the free velocities, and what is told of the others."""
        self._freedom = freedom
        contact = [freedom.kinds, freedom.axes, freedom.slip_stiffness]
        inputs = [self._system.pattern.diagonal_slot, self._values, *contact]
        self._launch(
            self._kernels.invert_pivots, self._system.node_count, inputs, [self._pivot_inverse]
        )
        if self._held_motions is not None:
            self._held_motions.prepare(freedom, self._node_rotations, self._unturned)

    def _launch(self, kernel: Any, dim: Any, inputs: list[Any], outputs: list[Any]) -> None:
        device = self._system.device
        launch(kernel, dim, inputs, outputs, device)

    def _parts(self) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
        """Arguments that the kernels share: rows, sweep, contact, aggregates."""
        pattern, groups = self._system.pattern, self._aggregates
        assert self._freedom is not None
        rows = [pattern.row_start, pattern.column, pattern.diagonal_slot]
        sweep = [self._values, self._pivot_inverse]
        contact = [self._freedom.kinds, self._freedom.axes, self._node_rotations]
        return rows, sweep, contact, [groups.start, groups.nodes, groups.offsets]

    def _solve_coarse(self) -> None:
        self._factor.solve(self._unturned, self._right, self._motion)
        if self._held_motions is not None:
            self._held_motions.correct(self._motion)

    def apply(self, residual: Any, result: Any) -> None:
        """Launch result = P residual, (n,) vec3."""
        system, groups, k = self._system, self._aggregates, self._kernels
        rows, sweep, contact, aggregates = self._parts()
        lanes, middle = self._lanes, [groups.aggregate_of, groups.offsets, *contact, self._motion]
        if lanes is not None:
            swept = [self._swept, self._behind]
            self._launch(lanes.sweep_forward, 1, [*rows, *sweep, residual], swept)
            inputs = [*aggregates, *contact, self._behind]
            self._launch(lanes.restrict_residual, len(self._right) // 2, inputs, [self._right])
            self._solve_coarse()
            self._launch(lanes.prolong, 1, middle, [self._swept])
            inputs = [*rows, *sweep, residual, self._swept]
            self._launch(lanes.sweep_backward, 1, inputs, [self._behind, result])
            return
        self._launch(k.sweep_forward, 1, [*rows, *sweep, residual], [result])
        inputs = [*rows, *aggregates, self._values, *contact, result]
        self._launch(k.restrict, len(self._right) // 2, inputs, [self._right])
        self._solve_coarse()
        self._launch(k.prolong, system.node_count, middle, [result])
        self._launch(k.sweep_backward, 1, [*rows, *sweep, residual], [result])

    def apply_block(self, residual: Any, work: Any, result: Any) -> None:
        """Launch result = P residual for blocks (blocks, 3n)."""
        system, groups, k = self._system, self._aggregates, self._kernels
        rows, sweep, contact, aggregates = self._parts()
        blocks = residual.shape[0]
        if blocks not in self._block_arrays:
            shape = (blocks, 3 * len(self._right))
            right, motion, spare = (system.zeros(shape, system.types.block) for _ in range(3))
            self._block_arrays[blocks] = (right, motion, spare)
        right, motion, spare = self._block_arrays[blocks]
        self._launch(k.sweep_forward_block, blocks, [*rows, *sweep, residual], [result])
        inputs = [*rows, *aggregates, self._values, *contact, result]
        self._launch(k.restrict_block, (blocks, len(self._right) // 2), inputs, [right])
        self._factor.solve_block(self._unturned, right, spare, motion)
        inputs = [groups.aggregate_of, groups.offsets, *contact, motion]
        self._launch(k.prolong_block, (blocks, system.node_count), inputs, [result])
        self._launch(k.sweep_backward_block, blocks, [*rows, *sweep, residual], [result])
