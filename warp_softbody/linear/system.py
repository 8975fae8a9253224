"""The constant part of the linear systems of a step: all that solvers know of a model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.device.allocator import Allocator, DeviceArray
from warp_softbody.kernels.precision import Real
from warp_softbody.linear.aggregation import Aggregation
from warp_softbody.linear.block_sparsity import Pattern
from warp_softbody.linear.symbolic_ldlt import Elimination

CHUNKS = 64
"""Pieces that sums over nodes are cut into; fixed, so that a sum does not depend on the machine."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class PatternArrays:
    """Sparsity of the matrix of n nodes, b blocks of 3 x 3.

    Attributes:
        row_start: (n + 1,) int32, first block of each row, and the end.
        column: (b,) int32, rising within each row, the diagonal included.
        diagonal_slot: (n,) int32, place of each row's diagonal block.
    """

    row_start: DeviceArray
    column: DeviceArray
    diagonal_slot: DeviceArray

    @staticmethod
    def of(pattern: Pattern, make: Allocator) -> PatternArrays:
        """A pattern on the device."""
        return PatternArrays(
            row_start=make.indices(pattern.row_start),
            column=make.indices(pattern.column),
            diagonal_slot=make.indices(pattern.diagonal_slot),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MassArrays:
    """Lumped masses of n nodes.

    Attributes:
        mass: (n,) scalar, m, kg.
        damped_mass: (n,) scalar, (1 + dt mu) m, kg, of M in the step's matrix.
        fixed: (n,) int32, 1 where the scene holds a node, else 0.
    """

    mass: DeviceArray
    damped_mass: DeviceArray
    fixed: DeviceArray


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class AggregateArrays:
    """Aggregates of n nodes, k of which are free.

    Attributes:
        aggregate_of: (n,) int32, aggregate of each node, -1 for a fixed one.
        start: (aggregates + 1,) int32, first entry of each in ``nodes``, and the end.
        nodes: (k,) int32, nodes by aggregate.
        offsets: (n,) vec3, rest place about the middle of the aggregate, of the aggregates' size.
        points: (n,) vec3 m, rest places.
    """

    aggregate_of: DeviceArray
    start: DeviceArray
    nodes: DeviceArray
    offsets: DeviceArray
    points: DeviceArray

    @staticmethod
    def of(aggregation: Aggregation, points: FloatArray, make: Allocator) -> AggregateArrays:
        """Aggregates of nodes at rest places (n, 3) m on the device."""
        return AggregateArrays(
            aggregate_of=make.indices(aggregation.aggregate_of),
            start=make.indices(aggregation.start),
            nodes=make.indices(aggregation.nodes),
            offsets=make.array(aggregation.offsets, make.types.vec3),
            points=make.array(points, make.types.vec3),
        )


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class CoarseLevel:
    """The coarse level of a large body.

    Attributes:
        aggregation: of its nodes, on the host.
        aggregates: the same on the device.
        values: (coarse blocks, 3, 3), the coarse matrix of the rest shape, kg and the like.
        held_margin: part of what contact holds that is let go, so that rounding of the coarse
            solution leaves its correction positive definite; None where it is told of no contact.
    """

    aggregation: Aggregation
    aggregates: AggregateArrays
    values: FloatArray
    held_margin: float | None

    @property
    def node_count(self) -> int:
        """Number of coarse nodes: the translation and the turn of each aggregate."""
        return 2 * self.aggregation.count


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class LinearSystem:
    """What stays constant of ``M~ x = b`` over the steps of a run.

    Attributes:
        allocator: makes arrays in the system's precision, on its device.
        node_count: n.
        pattern: of M~.
        masses: of the nodes.
        tolerance: (1,) float64, relative residual at which solves stop.
        follows_time_error: whether solves stop with the error of the time step, where that is more.
        max_iterations: of conjugate gradients in one solve.
        elimination: of the matrix that is factorised, the coarse one where there is a coarse level.
        pivot_margin: part of a pivot that is added to it.
        coarse: the coarse level; None where the whole matrix is factorised.
        native_code: whether kernels use native code for processors where there is some.
    """

    allocator: Allocator
    node_count: int
    pattern: PatternArrays
    masses: MassArrays
    tolerance: DeviceArray
    follows_time_error: bool
    max_iterations: int
    elimination: Elimination
    pivot_margin: float
    coarse: CoarseLevel | None
    native_code: bool

    @property
    def types(self) -> Real:
        """Warp types of the precision."""
        return self.allocator.types

    @property
    def device(self) -> str:
        """Name of the Warp device."""
        return self.allocator.device

    @cached_property
    def chunk(self) -> int:
        """Nodes per chunk of a sum."""
        return -(-self.node_count // CHUNKS)

    @cached_property
    def chunk_count(self) -> int:
        """Number of chunks that hold nodes."""
        return -(-self.node_count // self.chunk)

    def array(self, values: npt.ArrayLike, dtype: Any) -> DeviceArray:
        """A device array of values."""
        return self.allocator.array(values, dtype)

    def zeros(self, shape: int | tuple[int, ...], dtype: Any) -> DeviceArray:
        """A device array of zeros."""
        return self.allocator.zeros(shape, dtype)
