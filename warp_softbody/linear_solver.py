"""Conjugate gradients on the device."""

from __future__ import annotations

from typing import Any

import warp as wp

from warp_softbody.kernels import conjugate_gradients as cg
from warp_softbody.kernels.conjugate_gradients import make_conjugate_gradients
from warp_softbody.model import Model
from warp_softbody.preconditioner import Preconditioner


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
        """Launch the stopping residual: the tolerance times |momentum| of the free nodes."""
        a = self._model.arrays
        inputs = [a["tolerance"], a["fixed"], momentum]
        self._launch(self._kernels.set_target, inputs, [self.scalars], dim=1)

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
