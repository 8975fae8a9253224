"""Materials by body, as the assembly of a step takes them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_softbody.body.material import Material
from warp_softbody.device.allocator import Allocator, DeviceArray
from warp_softbody.linear.block_sparsity import Topology
from warp_softbody.world.joined_bodies import Part


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MaterialPart:
    """What the assembly needs of one body.

    Attributes:
        material: of the body.
        nodes, tets, edges: where it stands in the joined arrays.
        stiffness_factor: dt lambda + dt^2, of K in M~, s^2.
        mass_factor: 1 + dt mu, of M in M~.
        lame: (2,) scalar, mu and lambda, Pa.
        step_factors: (3,) scalar, dt, s, and the two factors.
    """

    material: Material
    nodes: slice
    tets: slice
    edges: slice
    stiffness_factor: float
    mass_factor: float
    lame: DeviceArray
    step_factors: DeviceArray


def material_parts(
    parts: tuple[Part, ...], topology: Topology, dt: float, make: Allocator
) -> tuple[MaterialPart, ...]:
    """The materials of all bodies; edges are sorted by their lower node, so by body."""
    low = topology.column[topology.edge_slots[:, 1]]
    scalar = make.types.scalar
    found = []
    for part in parts:
        material = part.material
        first, last = np.searchsorted(low, [part.nodes.start, part.nodes.stop]).tolist()
        stiffness = dt * material.stiffness_damping + dt * dt
        mass = 1.0 + dt * material.mass_damping
        found.append(
            MaterialPart(
                material=material,
                nodes=part.nodes,
                tets=part.tets,
                edges=slice(first, last),
                stiffness_factor=stiffness,
                mass_factor=mass,
                lame=make.array([material.lame_mu, material.lame_lambda], scalar),
                step_factors=make.array([dt, stiffness, mass], scalar),
            )
        )
    return tuple(found)
