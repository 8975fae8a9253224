"""What contact holds, on the coarse level."""

from __future__ import annotations

from typing import Any

import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.kernels.linear.held_motions import COLUMNS, make_held_motions
from warp_softbody.linear.block_ldlt import BlockFactor, Freedom
from warp_softbody.linear.system import CoarseLevel, LinearSystem


class HeldMotions:
    """Corrects coarse motions by what the nodes that contact holds resist.

    The coarse factor stays that of the body that nothing touches; what contact adds is of small
    rank, and found anew for every choice of contact modes by one solve of a block of right-hand
    sides. The kernels' module has the formula.
    """

    def __init__(
        self,
        system: LinearSystem,
        coarse: CoarseLevel,
        factor: BlockFactor,
        values: Any,
        margin: float,
    ) -> None:
        """Work arrays.

        Args:
            system: the constant part of the systems.
            coarse: its coarse level.
            factor: of the coarse matrix.
            values: of the whole matrix.
            margin: see ``CoarseLevel.held_margin``.
        """
        types, n, size = system.types, system.node_count, coarse.node_count
        self._system = system
        self._aggregates = coarse.aggregates
        self._factor = factor
        self._values = values
        self._margin = margin
        self._kernels = make_held_motions(types.name)
        self._resistances = system.zeros(n, types.mat33)
        self._held = system.zeros(n, wp.int32)
        self._distance = system.zeros(n, types.scalar)
        self._group_of = system.zeros(n, wp.int32)
        self._count = system.zeros(1, wp.int32)
        self._touched = system.zeros(coarse.aggregation.count, wp.int32)
        self._columns, self._answers, self._spare = (
            system.zeros((1, 3 * size), types.block) for _ in range(3)
        )
        self._small = system.zeros((COLUMNS, COLUMNS), wp.float64)
        self._work = system.zeros(COLUMNS, wp.float64)
        self._multipliers = system.zeros(1, types.block)

    def _launch(self, kernel: Any, dim: int, inputs: list[Any], outputs: list[Any]) -> None:
        launch(kernel, dim, inputs, outputs, self._system.device)

    def prepare(self, freedom: Freedom, node_rotations: Any, unturned: Any) -> None:
        """Launch what corrections need, for velocities that contact holds or brakes.

        ``node_rotations`` (n,) mat33 are those since rest, ``unturned`` (coarse nodes,) mat33 ones.
        """
        system, groups, k = self._system, self._aggregates, self._kernels
        inputs = [system.pattern.diagonal_slot, self._values]
        inputs += [freedom.kinds, freedom.axes, freedom.slip_stiffness]
        self._launch(k.find_resistances, system.node_count, inputs, [self._resistances])
        inputs = [groups.aggregate_of, groups.points, self._resistances]
        outputs = [self._held, self._distance, self._group_of, self._count]
        self._launch(k.part_held_nodes, 1, inputs, outputs)

        def answer() -> None:
            inputs = [groups.start, groups.nodes, groups.offsets]
            inputs += [self._resistances, node_rotations, self._group_of]
            outputs = [self._touched, self._columns]
            self._launch(k.gather_columns, len(self._touched), inputs, outputs)
            self._factor.solve_block(unturned, self._columns, self._spare, self._answers)
            inputs = [self._margin, self._resistances, self._held, self._group_of, self._count]
            inputs += [self._touched, self._columns, self._answers]
            self._launch(k.factorise_small, 1, inputs, [self._small])

        wp.capture_if(self._count, answer)

    def correct(self, motion: Any) -> None:
        """Launch the correction of (coarse nodes,) vec3, the factor's solution, in place."""
        k = self._kernels
        inputs = [self._count, self._touched, self._columns, self._small, motion]
        self._launch(k.find_multipliers, 1, inputs, [self._work, self._multipliers])
        inputs = [self._count, self._answers, self._multipliers]
        self._launch(k.subtract_answers, len(motion), inputs, [motion])
