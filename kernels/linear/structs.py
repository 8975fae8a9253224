"""Structs of kernel arguments that belong together: the matrix, and what holds its nodes."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


@cache
def make_linear_structs(precision: str) -> SimpleNamespace:
    """Structs of the matrix of a step beside its values, and of sums over chunks of nodes."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3

    @wp.struct
    class MatrixRows:
        """Sparsity of M~ beside its values, and the masses in it."""

        row_start: wp.array(dtype=int)
        column: wp.array(dtype=int)
        diagonal_slot: wp.array(dtype=int)
        masses: wp.array(dtype=scalar)
        damped_masses: wp.array(dtype=scalar)

    @wp.struct
    class NodeConstraints:
        """The velocity constraint of each node: its kind, and the axis that goes with it."""

        kinds: wp.array(dtype=int)
        axes: wp.array(dtype=vec3)

    @wp.struct
    class ResidualSums:
        """Of each chunk: squares of the residual and of what moved, N s, and the net residual."""

        squares: wp.array(dtype=wp.float64)
        moved: wp.array(dtype=wp.float64)
        net: wp.array(dtype=wp.vec3d)

    return SimpleNamespace(
        MatrixRows=MatrixRows, NodeConstraints=NodeConstraints, ResidualSums=ResidualSums
    )
