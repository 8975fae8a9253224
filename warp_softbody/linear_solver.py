"""Conjugate gradients on the device, and the factor that preconditions them."""

from __future__ import annotations

from typing import Any

import warp as wp

from warp_softbody.kernels import conjugate_gradients as cg
from warp_softbody.kernels.cholesky import make_cholesky
from warp_softbody.kernels.conjugate_gradients import make_conjugate_gradients
from warp_softbody.model import Model


class Preconditioner:
    """An L D L^T factor of an earlier matrix, warped by the rotations of the nodes since then.

    It is stale when the iterations that a fresh factor would have saved would have paid for it; a
    count, not a clock, so that runs repeat.
    """

    def __init__(self, model: Model, values: Any, node_rotations: Any, *, cost: float) -> None:
        """Arrays for the factor of the matrix in ``values``; nothing is computed yet.

        ``cost`` is that of one factorisation in units of the iterations it is used for.
        """
        types, count = model.types, len(model.elimination.column)
        self._model = model
        self._values = values
        self._node_rotations = node_rotations
        self._cost = cost
        self._excess = float("inf")
        self._kernels = make_cholesky(model.options.precision)
        self._upper = model.zeros(count, types.mat33)
        self._lower = model.zeros(count, types.mat33)
        self._pivot_inverse = model.zeros(model.node_count, types.mat33)
        self._factor_rotations = model.zeros(model.node_count, types.mat33)
        self._turns = model.zeros(model.node_count, types.mat33)
        self._work = model.zeros(model.node_count, types.vec3)

    @property
    def stale(self) -> bool:
        """Whether a new factor is due."""
        return self._excess > self._cost

    def renewed(self) -> None:
        """Note that the factor is of the present matrix."""
        self._excess = 0.0

    def used(self, iterations: int, fresh: int) -> None:
        """Count iterations beyond those that even a fresh factor would have needed."""
        self._excess += max(0, iterations - fresh)

    def factorise(self, kinds: Any, normals: Any, slip_stiffness: Any) -> None:
        """Launch the factorisation of the present matrix on the velocities left free."""
        a, n = self._model.arrays, self._model.node_count
        wp.launch(
            self._kernels.factorise,
            dim=1,
            inputs=[
                n,
                a["factor_row_start"],
                a["factor_column"],
                a["factor_matrix_slot"],
                a["factor_diagonal_slot"],
                a["update_start"],
                a["update_pairs"],
                a["order"],
                self._values,
                kinds,
                normals,
                slip_stiffness,
            ],
            outputs=[self._upper, self._lower, self._pivot_inverse],
            device=self._model.options.device,
        )
        wp.launch(
            self._kernels.keep_rotations,
            dim=n,
            inputs=[self._node_rotations],
            outputs=[self._factor_rotations],
            device=self._model.options.device,
        )

    def follow_rotations(self) -> None:
        """Launch the update of each node's rotation since the factorisation."""
        wp.launch(
            self._kernels.node_turns,
            dim=self._model.node_count,
            inputs=[self._node_rotations, self._factor_rotations],
            outputs=[self._turns],
            device=self._model.options.device,
        )

    def _factor(self) -> list[Any]:
        a = self._model.arrays
        return [
            self._model.node_count,
            a["order"],
            a["factor_row_start"],
            a["factor_column"],
            self._lower,
            self._pivot_inverse,
            self._turns,
        ]

    def apply(self, residual: Any, result: Any) -> None:
        """Launch result = P residual, (n,) vec3."""
        wp.launch(
            self._kernels.precondition,
            dim=1,
            inputs=[*self._factor(), residual],
            outputs=[self._work, result],
            device=self._model.options.device,
        )

    def apply_block(self, residual: Any, work: Any, result: Any) -> None:
        """Launch result = P residual for blocks (blocks, 3n)."""
        wp.launch(
            self._kernels.precondition_block,
            dim=residual.shape[0],
            inputs=[*self._factor(), residual],
            outputs=[work, result],
            device=self._model.options.device,
        )


class ConjugateGradients:
    """S (M~ + G) S v = S b, G the slip stiffness, v given where S is zero; made to be captured."""

    def __init__(self, model: Model, values: Any, preconditioner: Preconditioner) -> None:
        """Work arrays for the matrix in ``values``."""
        types, n = model.types, model.node_count
        self._model = model
        self._values = values
        self._preconditioner = preconditioner
        self._kernels = make_conjugate_gradients(model.options.precision)
        self._vectors = {name: model.zeros(n, types.vec3) for name in "rzpq"}
        self._sums = {
            name: model.zeros(model.chunk_count, wp.float64) for name in ("rr", "rz", "pq")
        }
        self.scalars = model.zeros(cg.SCALARS, wp.float64)
        self.counters = model.zeros(cg.COUNTERS, wp.int32)
        self.kinds = model.zeros(n, wp.int32)
        self.normals = model.zeros(n, types.vec3)

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any], dim: int = 0) -> None:
        wp.launch(
            kernel,
            dim=dim or self._model.chunk_count,
            inputs=inputs,
            outputs=outputs,
            device=self._model.options.device,
        )

    def set_target(self, momentum: Any) -> None:
        """Launch the stopping residual: the tolerance times |momentum|."""
        tolerance = self._model.arrays["tolerance"]
        self._launch(self._kernels.set_target, [tolerance, momentum], [self.scalars], dim=1)

    def solve(self, right_side: Any, slip_stiffness: Any, x: Any) -> None:
        """Launch the iteration from the x given, in place."""
        m, k, v, s = self._model, self._kernels, self._vectors, self._sums
        rows = [m.chunk, m.arrays["row_start"], m.arrays["column"]]
        surroundings = [self._values, self.kinds, self.normals, slip_stiffness]
        self._launch(k.residual, [*rows, *surroundings, right_side, x], [v["r"], s["rr"]])
        self._launch(k.begin, [s["rr"]], [self.scalars, self.counters], dim=1)

        def iterate() -> None:
            self._preconditioner.apply(v["r"], v["z"])
            filtered = [m.chunk, self.kinds, self.normals, v["r"]]
            self._launch(k.filtered_product, filtered, [v["z"], s["rz"]])
            self._launch(k.direction, [m.chunk, s["rz"], self.scalars, v["z"]], [v["p"]])
            self._launch(k.product, [*rows, *surroundings, v["p"]], [v["q"], s["pq"]])
            inputs = [m.chunk, s["rz"], s["pq"], v["p"], v["q"]]
            self._launch(k.advance, inputs, [x, v["r"], s["rr"]])
            inputs = [m.options.max_iterations, s["rz"], s["rr"]]
            self._launch(k.conclude, inputs, [self.scalars, self.counters], dim=1)

        wp.capture_while(self.counters[cg.CONDITION : cg.CONDITION + 1], iterate)
