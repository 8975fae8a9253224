"""Rows of the matrix in native code against the plain kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.support.bodies import epsilon
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.options import Precision
from warp_softbody.kernels.linear.pcg import make_products
from warp_softbody.kernels.linear.product_lanes import make_product_lanes
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import real

NODES, AROUND = 13, 5


class System:
    """A random symmetric matrix of blocks, nodes of every kind, and some vectors."""

    def __init__(self, precision: Precision) -> None:
        """The same numbers in either precision."""
        self._types = real(precision)
        self._random = np.random.default_rng(3)
        rng = self._random
        places = np.zeros((NODES, NODES), dtype=bool)
        places[np.repeat(np.arange(NODES), AROUND), rng.integers(0, NODES, AROUND * NODES)] = True
        places |= places.T | np.eye(NODES, dtype=bool)
        owners, columns = np.nonzero(places)
        starts = np.searchsorted(owners, np.arange(NODES + 1))
        structs = make_linear_structs(precision)
        self.rows = struct_of(
            structs.MatrixRows,
            row_start=self.array(starts, int),
            column=self.array(columns, int),
            diagonal_slot=self.array(np.flatnonzero(owners == columns), int),
            masses=self.array(rng.uniform(1.0, 2.0, NODES), self._types.scalar),
            damped_masses=self.array(rng.uniform(2.0, 3.0, NODES), self._types.scalar),
        )
        axes = self.vectors().numpy()
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        kinds = self.array(np.arange(NODES) % 4, int)
        axes = self.array(axes, self._types.vec3)
        constraints = struct_of(structs.NodeConstraints, kinds=kinds, axes=axes)
        blocks = rng.standard_normal((NODES, NODES, 3, 3))
        blocks += blocks.transpose(1, 0, 3, 2)
        values = self.array(blocks[places], self._types.mat33)
        slip = self.array(rng.standard_normal((NODES, 3, 3)), self._types.mat33)
        self.operator = [self.rows, values, constraints, slip]

    def array(self, values: Any, dtype: Any) -> Any:
        """A device array."""
        return wp.array(values, dtype=dtype, device="cpu")

    def vectors(self) -> Any:
        """A vector a node."""
        return self.array(self._random.standard_normal((NODES, 3)), self._types.vec3)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("name", ["product", "residual"])
def test_native_rows_give_what_the_plain_ones_give(name: str, precision: Precision) -> None:
    """To a few roundings."""
    system, chunk = System(precision), 4
    inputs = [chunk, *system.operator, system.vectors()]
    if name == "residual":
        vectors = [system.vectors() for _ in range(4)]
        inputs = [chunk, 1, *system.operator, *vectors]
    chunks = -(-NODES // chunk)
    residual_sums = make_linear_structs(precision).ResidualSums
    found = []
    for make in (make_product_lanes, make_products):
        vector = wp.zeros(NODES, dtype=real(precision).vec3, device="cpu")
        squares, moved = (wp.zeros(chunks, dtype=wp.float64, device="cpu") for _ in range(2))
        arrays: list[Any] = [vector, squares, moved]
        out = list(arrays)
        if name == "residual":
            net = wp.zeros(chunks, dtype=wp.vec3d, device="cpu")
            arrays.append(net)
            out = [vector, struct_of(residual_sums, squares=squares, moved=moved, net=net)]
        dim = chunks
        if name == "product" and make is make_product_lanes:
            dim, out = 1, [*out, wp.zeros(NODES, dtype=real(precision).vec4, device="cpu")]
        kernel = getattr(make(precision), name)
        wp.launch(kernel, dim=dim, inputs=inputs, outputs=out, device="cpu")
        found.append([array.numpy() for array in arrays])
    for mine, expected in zip(*found, strict=True):
        bound = 64 * epsilon(precision) * np.abs(expected).max()
        np.testing.assert_allclose(mine, expected, rtol=0.0, atol=bound)
        assert np.abs(expected).max() > 0.1
