"""Conjugate gradients on the device."""

from __future__ import annotations

from typing import Any, Protocol

import warp as wp

from warp_softbody.kernels import conjugate_gradients as cg
from warp_softbody.kernels.conjugate_gradients import make_conjugate_gradients
from warp_softbody.model import Model
from warp_softbody.preconditioner import Preconditioner


class Constraints(Protocol):
    """Constraints between nodes; P is the projector onto the velocities that they leave free."""

    def finish_residual(self, x: Any, r: Any, partial: Any) -> None:
        """Launch r = P (b - matrix x) from S (b - (M~ + G) x), and its square."""
        ...

    def project(self, v: Any) -> None:
        """Launch v = P v for v = S v."""
        ...

    def finish_product(self, p: Any, q: Any, partial: Any) -> None:
        """Launch q = P matrix p from S (M~ + G) p; what it adds to p . q is added to the sums."""
        ...


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
        self.axes = model.zeros(n, types.vec3)

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any], dim: int = 0) -> None:
        wp.launch(
            kernel,
            dim=dim or self._model.chunk_count,
            inputs=inputs,
            outputs=outputs,
            device=self._model.options.device,
        )

    def set_target(self, momentum: Any) -> None:
        """Launch the stopping residual: the tolerance times |momentum| of the free nodes."""
        a = self._model.arrays
        inputs = [a["tolerance"], a["fixed"], momentum]
        self._launch(self._kernels.set_target, inputs, [self.scalars], dim=1)

    def residual(self, right_side: Any, slip_stiffness: Any, x: Any) -> Any:
        """Launch r = S (b - (M~ + G) x); the array that it is written to."""
        rows, surroundings = self._operator(slip_stiffness)
        outputs = [self._vectors["r"], self._sums["rr"]]
        self._launch(self._kernels.residual, [*rows, *surroundings, right_side, x], outputs)
        return self._vectors["r"]

    def _operator(self, slip_stiffness: Any) -> tuple[list[Any], list[Any]]:
        rows = [self._model.chunk, self._model.arrays["row_start"], self._model.arrays["column"]]
        return rows, [self._values, self.kinds, self.axes, slip_stiffness]

    def solve(
        self, right_side: Any, slip_stiffness: Any, x: Any, constraints: Constraints | None = None
    ) -> None:
        """Launch the iteration from the x given, in place.

        Constraints narrow S to a part of the free velocities, and may add to the matrix.
        """
        m, k, v, s = self._model, self._kernels, self._vectors, self._sums
        rows, surroundings = self._operator(slip_stiffness)
        self.residual(right_side, slip_stiffness, x)
        if constraints is not None:
            constraints.finish_residual(x, v["r"], s["rr"])
        self._launch(k.begin, [s["rr"]], [self.scalars, self.counters], dim=1)

        def iterate() -> None:
            self._preconditioner.apply(v["r"], v["z"])
            filtered = [m.chunk, self.kinds, self.axes, v["r"]]
            self._launch(k.filtered_product, filtered, [v["z"], s["rz"]])
            if constraints is not None:
                # r is in the narrowed space, so its product with z stays what it is
                constraints.project(v["z"])
            self._launch(k.add_up, [cg.NEW_PRODUCT, s["rz"]], [self.scalars], dim=1)
            self._launch(k.direction, [m.chunk, self.scalars, v["z"]], [v["p"]])
            self._launch(k.product, [*rows, *surroundings, v["p"]], [v["q"], s["pq"]])
            if constraints is not None:
                constraints.finish_product(v["p"], v["q"], s["pq"])
            self._launch(k.add_up, [cg.CURVATURE, s["pq"]], [self.scalars], dim=1)
            self._launch(k.advance, [m.chunk, self.scalars, v["p"], v["q"]], [x, v["r"], s["rr"]])
            inputs = [m.options.max_iterations, s["rr"]]
            self._launch(k.conclude, inputs, [self.scalars, self.counters], dim=1)

        wp.capture_while(self.counters[cg.CONDITION : cg.CONDITION + 1], iterate)
