"""Conjugate gradients on the device."""

from __future__ import annotations

from typing import Any, Protocol

import warp as wp

from warp_softbody.device.launching import launch
from warp_softbody.device.structs import struct_of
from warp_softbody.kernels.linear.codes import Counter, Scalar
from warp_softbody.kernels.linear.pcg import make_conjugate_gradients, make_products
from warp_softbody.kernels.linear.product_lanes import product_lanes_on
from warp_softbody.kernels.linear.stopping import make_stopping
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.linear.vector_lanes import vector_lanes_on
from warp_softbody.linear.preconditioner import Preconditioner
from warp_softbody.linear.system import LinearSystem


class Constraints(Protocol):
    """Constraints between nodes; P is the projector onto the velocities that they leave free."""

    def finish_residual(self, r: Any, partial: Any) -> None:
        """Launch r = P (b - matrix x) from S (b - (M~ + G) x), and its square."""
        ...

    def project(self, v: Any) -> None:
        """Launch v = P v for v = S v."""
        ...

    def finish_product(self, p: Any, q: Any, partial: Any) -> None:
        """Launch q = P matrix p from S (M~ + G) p; what it adds to p . q is added to the sums."""
        ...


class ConjugateGradients:
    """S (M~ + G) v+ = S (M v + b), G the slip stiffness, v+ given where S is zero.

    Made to be captured.

    Attributes:
        counters, scalars: (k,) by `Counter` and `Scalar`.
        rows: struct of the matrix beside its values, and the masses in it.
        constraints: struct of the velocity constraints, ``kinds`` and ``axes``.
        failed: (1,) int, whether the last solve did not converge.
    """

    def __init__(
        self,
        system: LinearSystem,
        values: Any,
        preconditioner: Preconditioner,
        *,
        hasty: bool = False,
    ) -> None:
        """Work arrays for the matrix in ``values``.

        A ``hasty`` solver iterates less while contact modes are sought
        (``kernels/linear/stopping``).
        """
        types, n = system.types, system.node_count
        self._system = system
        self._values = values
        self._preconditioner = preconditioner
        lanes = product_lanes_on(system.device, types.name) if system.native_code else None
        self._products = lanes or make_products(types.name)
        vectors = vector_lanes_on(system.device, types.name) if system.native_code else None
        self._kernels = make_conjugate_gradients(types.name)
        self._updates = vectors or self._kernels
        self._work = system.zeros(n, types.vec4) if lanes else None
        self._stopping = make_stopping(types.name)
        self._vectors = {name: system.zeros(n, types.vec3) for name in "rzpq"}
        self._sums = {
            name: system.zeros(system.chunk_count, wp.float64)
            for name in ("rr", "rz", "pq", "pp", "change")
        }
        self._net = system.zeros(system.chunk_count, wp.vec3d)
        structs, s = make_linear_structs(types.name), self._sums
        self._residual_sums = struct_of(
            structs.ResidualSums, squares=s["rr"], moved=s["change"], net=self._net
        )
        self.scalars = system.zeros(len(Scalar), wp.float64)
        self.counters = system.zeros(len(Counter), wp.int32)
        self.failed = self.counters[Counter.FAILED : Counter.FAILED + 1]
        self._follows = int(system.follows_time_error)
        self._hasty = int(hasty)
        self.before = system.zeros(n, types.vec3)
        self.start = system.zeros(n, types.vec3)
        self.kinds = system.zeros(n, wp.int32)
        self.normals = system.zeros(n, types.vec3)
        self.axes = system.zeros(n, types.vec3)
        self.constraints = struct_of(structs.NodeConstraints, self)
        masses = system.masses
        self.rows = struct_of(
            structs.MatrixRows,
            system.pattern,
            masses=masses.mass,
            damped_masses=masses.damped_mass,
        )

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any], dim: int = 0) -> None:
        launch(kernel, dim or self._system.chunk_count, inputs, outputs, self._system.device)

    def begin_step(self) -> None:
        """Launch what precedes the solves of a step."""
        self._launch(self._stopping.begin_step, [self._hasty], [self.counters], dim=1)

    def set_target(self, impulses: Any) -> None:
        """Launch the stopping residual: the tolerance times |M v + impulses| of the free nodes."""
        masses = self._system.masses
        inputs = [self._system.tolerance, masses.fixed, masses.mass, self.before, impulses]
        self._launch(self._stopping.set_target, inputs, [self.scalars], dim=1)

    def residual(self, right_side: Any, slip_stiffness: Any, change: Any) -> Any:
        """Launch r = S (M v + b - (M~ + G) (v + change)); the array that it is written to."""
        inputs = [self._system.chunk, self._follows, self.rows, self._values, self.constraints]
        inputs += [slip_stiffness, right_side, self.before, self.start, change]
        outputs = [self._vectors["r"], self._residual_sums]
        self._launch(self._products.residual, inputs, outputs)
        return self._vectors["r"]

    def solve(
        self,
        right_side: Any,
        slip_stiffness: Any,
        change: Any,
        constraints: Constraints | None = None,
        *,
        first: bool = False,
        again: bool = False,
    ) -> None:
        """Launch the iteration from the change of velocities given, in place.

        Constraints narrow S to a part of the free velocities, and may add to the matrix.
        The ``first`` solve of a step that follows its time error makes an iteration at least; one
        that goes on ``again`` takes back that the one before it did not converge.
        """
        system, k, v, s = self._system, self._kernels, self._vectors, self._sums
        updates = self._updates
        self.residual(right_side, slip_stiffness, change)
        if constraints is not None:
            constraints.finish_residual(v["r"], s["rr"])
        inputs = [system.tolerance, self._follows, system.node_count, self._hasty]
        inputs += [s["rr"], s["change"], self._net, int(first), int(again)]
        self._launch(self._stopping.begin, inputs, [self.scalars, self.counters], dim=1)

        def iterate() -> None:
            self._preconditioner.apply(v["r"], v["z"])
            filtered = [system.chunk, self.constraints, v["r"]]
            self._launch(updates.filtered_product, filtered, [v["z"], s["rz"]])
            if constraints is not None:
                # r is in the narrowed space, so its product with z stays what it is
                constraints.project(v["z"])
            self._launch(k.add_up, [int(Scalar.NEW_PRODUCT), s["rz"]], [self.scalars], dim=1)
            self._launch(updates.direction, [system.chunk, self.scalars, v["z"]], [v["p"]])
            inputs = [system.chunk, self.rows, self._values, self.constraints]
            inputs += [slip_stiffness, v["p"]]
            outputs = [v["q"], s["pq"], s["pp"]]
            if self._work is None:
                self._launch(self._products.product, inputs, outputs)
            else:
                self._launch(self._products.product, inputs, [*outputs, self._work], dim=1)
            if constraints is not None:
                constraints.finish_product(v["p"], v["q"], s["pq"])
            self._launch(k.add_up_curvature, [s["pq"], s["pp"]], [self.scalars], dim=1)
            inputs = [system.chunk, self._follows, system.masses.mass, self.scalars]
            outputs = [change, v["r"], self._residual_sums]
            self._launch(updates.advance, [*inputs, v["p"], v["q"], self.start], outputs)
            inputs = [system.max_iterations, self._follows, system.node_count]
            inputs += [s["rr"], s["change"], self._net]
            self._launch(self._stopping.conclude, inputs, [self.scalars, self.counters], dim=1)

        wp.capture_while(self.counters[Counter.CONDITION : Counter.CONDITION + 1], iterate)
