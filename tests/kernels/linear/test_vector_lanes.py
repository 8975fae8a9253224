"""Vector operations of conjugate gradients in native code against the plain kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.support.bodies import epsilon
from warp_softbody.device.structs import struct_of
from warp_softbody.engine.options import Precision
from warp_softbody.kernels.linear.codes import Scalar, VelocityConstraint
from warp_softbody.kernels.linear.pcg import make_conjugate_gradients
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.linear.vector_lanes import make_vector_lanes
from warp_softbody.kernels.precision import real

NODES, CHUNK = 61, 7
"""Neither is a multiple of a register's numbers."""


def launched(name: str, precision: Precision, make: Any, follows: int) -> list[Any]:
    """What a kernel writes, as arrays, from the same random numbers every time."""
    types, rng, chunks = real(precision), np.random.default_rng(4), -(-NODES // CHUNK)
    structs = make_linear_structs(precision)

    def vectors() -> Any:
        numbers = rng.standard_normal((NODES, 3))
        return wp.array(numbers, dtype=types.vec3, device="cpu")

    def sums(dtype: Any = wp.float64) -> Any:
        return wp.zeros(chunks, dtype=dtype, device="cpu")

    axes = rng.standard_normal((NODES, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    kinds = rng.choice([int(kind) for kind in VelocityConstraint], NODES)
    constraints = struct_of(
        structs.NodeConstraints,
        kinds=wp.array(kinds, dtype=int, device="cpu"),
        axes=wp.array(axes, dtype=types.vec3, device="cpu"),
    )
    scalars: Any = wp.array(rng.uniform(0.5, 1.0, len(Scalar)), dtype=wp.float64, device="cpu")
    a, b, c, d, e = (vectors() for _ in range(5))
    masses: Any = wp.array(rng.uniform(1.0, 2.0, NODES), dtype=types.scalar, device="cpu")
    squares, moved, net = sums(), sums(), sums(wp.vec3d)
    arguments: dict[str, tuple[list[Any], list[Any], list[Any]]] = {
        "filtered_product": ([CHUNK, constraints, a], [b, squares], [b, squares]),
        "direction": ([CHUNK, scalars, a], [b], [b]),
        "advance": (
            [CHUNK, follows, masses, scalars, a, b, c],
            [d, e, struct_of(structs.ResidualSums, squares=squares, moved=moved, net=net)],
            [d, e, squares, moved, net],
        ),
    }
    inputs, outputs, found = arguments[name]
    kernel = getattr(make(precision), name)
    wp.launch(kernel, dim=chunks, inputs=inputs, outputs=outputs, device="cpu")
    return [array.numpy() for array in found]


@pytest.mark.parametrize("follows", [0, 1])
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("name", ["filtered_product", "direction", "advance"])
def test_native_vectors_give_what_the_plain_ones_give(
    name: str, precision: Precision, follows: int
) -> None:
    """To a few roundings of the numbers; sums are double in both."""
    native = launched(name, precision, make_vector_lanes, follows)
    plain = launched(name, precision, make_conjugate_gradients, follows)
    for found, expected in zip(native, plain, strict=True):
        bound = 16 * epsilon(precision) * np.abs(expected).max()
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=bound)
