"""Kernels that every scene launches on a processor, so that they can be compiled before the rest.

While they are, the model is built. Their modules are whole once the factories named here have run:
a module that gets further kernels later would be compiled twice.
"""

from __future__ import annotations

from typing import Any

from warp_softbody.kernels.contact.step_ends import make_step_ends
from warp_softbody.kernels.elastic.rotation_lanes import make_rotation_lanes
from warp_softbody.kernels.linear.product_lanes import make_product_lanes
from warp_softbody.kernels.linear.supernodes import make_supernodes
from warp_softbody.kernels.linear.vector_lanes import make_vector_lanes
from warp_softbody.kernels.rigid_balance import make_rigid_balance


def first_kernels(precision: str) -> list[Any]:
    """One kernel of each such module."""
    return [
        make_rigid_balance(precision).balance,
        make_step_ends(precision).right_side,
        make_rotation_lanes(precision).rotate,
        make_product_lanes(precision).product,
        make_supernodes(precision).precondition,
        make_vector_lanes(precision).direction,
    ]
