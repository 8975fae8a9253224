"""Kernels that are launched on a processor whatever a scene holds, to be compiled before the rest.

While they are, the model is built. Their modules are whole once the factories named here have run:
a module that gets further kernels later would be compiled twice.
"""

from __future__ import annotations

from typing import Any

from warp_softbody.kernels.account import make_account
from warp_softbody.kernels.contact.step_ends import make_step_ends
from warp_softbody.kernels.control.reduced_maps import make_reduced_maps
from warp_softbody.kernels.elastic.node_lanes import make_node_lanes
from warp_softbody.kernels.elastic.rotation_lanes import make_rotation_lanes
from warp_softbody.kernels.fiber_edges import make_fiber_edges
from warp_softbody.kernels.fiber_lanes import make_fiber_lanes
from warp_softbody.kernels.flight.groups import make_flight_groups
from warp_softbody.kernels.implicit_muscles import make_implicit_muscles
from warp_softbody.kernels.linear.block_lanes import make_block_lanes
from warp_softbody.kernels.linear.block_pcg import make_block_gradients
from warp_softbody.kernels.linear.ldlt_factor import make_factorisation
from warp_softbody.kernels.linear.pcg import make_conjugate_gradients
from warp_softbody.kernels.linear.product_lanes import make_product_lanes
from warp_softbody.kernels.linear.supernodes import make_supernodes
from warp_softbody.kernels.linear.vector_lanes import make_vector_lanes
from warp_softbody.kernels.linear.warped_ldlt import make_cholesky
from warp_softbody.kernels.rigid_balance import make_rigid_balance


def first_kernels(precision: str) -> list[Any]:
    """One kernel of each module that every scene needs."""
    # two factories make kernels of one module
    make_cholesky(precision)
    return [
        make_rigid_balance(precision).balance,
        make_step_ends(precision).right_side,
        make_rotation_lanes(precision).rotate,
        make_product_lanes(precision).product,
        make_supernodes(precision).precondition,
        make_vector_lanes(precision).direction,
        make_factorisation(precision).factorise,
        make_account(precision).find_shapes,
        make_flight_groups(precision).choose_bodies,
        make_conjugate_gradients(precision).add_up,
        make_node_lanes(precision).finish_nodes,
    ]


def reduced_kernels(precision: str) -> list[Any]:
    """One kernel of each module that reduced dynamics need besides."""
    return [
        make_block_lanes(precision).residual,
        make_block_gradients(precision).direction,
        make_reduced_maps(precision).gather,
    ]


def muscle_kernels(precision: str) -> list[Any]:
    """One kernel of the module of implicit muscles, which three factories make."""
    plain = make_implicit_muscles(precision)
    make_fiber_edges(precision)
    return [make_fiber_lanes(precision, plain.Fibers, plain.FiberState).share_corners]
