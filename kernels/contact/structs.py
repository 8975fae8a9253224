"""Structs of kernel arguments that belong together: contacts, their states, and what a pass notes.

Shapes and units of the fields stand with the records that the engine fills them from
(``warp_softbody/engine/contact_arrays.py``, ``warp_softbody/engine/state.py``).
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real


@cache
def make_contact_structs(precision: str) -> SimpleNamespace:
    """Structs of the contacts with the ground, and of any contacts."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    vec2 = wp.types.vector(length=2, dtype=scalar)

    @wp.struct
    class Tolerances:
        """What counts as zero."""

        impulse: scalar
        normal_speed: scalar
        sliding_speed: scalar

    @wp.struct
    class GroundContacts:
        """The surface nodes that may touch the ground, and their law of friction."""

        nodes: wp.array(dtype=int)
        fixed: wp.array(dtype=int)
        friction: wp.array(dtype=scalar)
        forward: wp.array(dtype=vec3)
        friction_factors: wp.array2d(dtype=scalar)
        tolerances: Tolerances
        max_passes: int

    @wp.struct
    class VelocityUpdate:
        """Velocities of the nodes before the step, and what the step adds to them."""

        before: wp.array(dtype=vec3)
        change: wp.array(dtype=vec3)

    @wp.struct
    class ContactPlanes:
        """The contact plane of each surface node in a step."""

        normals: wp.array(dtype=vec3)
        normal_velocity: wp.array(dtype=scalar)

    @wp.struct
    class ContactStates:
        """Modes and impulses of contacts, and the linearised friction of those that slide."""

        modes: wp.array(dtype=int)
        impulses: wp.array(dtype=vec3)
        friction_forces: wp.array(dtype=vec3)
        slip_velocities: wp.array(dtype=vec3)
        slip_stiffness: wp.array(dtype=mat33)

    @wp.struct
    class PassRecord:
        """What a pass changed of each contact, and by how much each missed its laws."""

        changed: wp.array(dtype=int)
        violations: wp.array(dtype=vec2)

    return SimpleNamespace(
        Tolerances=Tolerances,
        GroundContacts=GroundContacts,
        VelocityUpdate=VelocityUpdate,
        ContactPlanes=ContactPlanes,
        ContactStates=ContactStates,
        PassRecord=PassRecord,
    )


@cache
def make_pair_structs(precision: str) -> SimpleNamespace:
    """Structs of pairs: of surface nodes with triangles, and of edges with edges."""
    types = real(precision)
    scalar, vec3, vec4 = types.scalar, types.vec3, types.vec4

    @wp.struct
    class Pairs:
        """The pairs of a step: those found, and among them the active ones, which are pressed."""

        nodes: wp.array(dtype=wp.vec4i)
        weights: wp.array(dtype=vec4)
        normals: wp.array(dtype=vec3)
        normal_velocity: wp.array(dtype=scalar)
        friction_factor: wp.array(dtype=scalar)
        found: wp.array(dtype=int)
        found_count: wp.array(dtype=int)
        active: wp.array(dtype=int)
        active_count: wp.array(dtype=int)
        marks: wp.array(dtype=int)
        touched: wp.array(dtype=int)
        constrained: wp.array(dtype=int)
        node_counts: wp.array(dtype=int)

    @wp.struct
    class DelassusWork:
        """Scratch of the solves with the pairs' Delassus matrix, and its factor."""

        nodal: wp.array(dtype=wp.vec3d)
        y: wp.array(dtype=wp.vec3d)
        r: wp.array(dtype=wp.vec3d)
        p: wp.array(dtype=wp.vec3d)
        q: wp.array(dtype=wp.vec3d)
        rank: wp.array(dtype=int)
        codes: wp.array(dtype=int)
        chosen: wp.array(dtype=int)
        pivots: wp.array(dtype=wp.float64)
        lower: wp.array(dtype=wp.float64)

    @wp.struct
    class NodeCandidates:
        """For each surface node the triangle that it may touch."""

        corners: wp.array(dtype=wp.vec3i)
        weights: wp.array(dtype=vec3)
        normals: wp.array(dtype=vec3)
        gaps: wp.array(dtype=scalar)
        deep: wp.array(dtype=int)
        areas: wp.array(dtype=vec3)

    @wp.struct
    class EdgeCandidates:
        """For each half of an edge the edge that it may cross, and how deep the edge is."""

        crossed: wp.array(dtype=int)
        places: wp.array(dtype=vec4)
        normals: wp.array(dtype=vec3)
        gaps: wp.array(dtype=scalar)
        deep: wp.array(dtype=int)
        inner: wp.array(dtype=scalar)

    return SimpleNamespace(
        Pairs=Pairs,
        DelassusWork=DelassusWork,
        NodeCandidates=NodeCandidates,
        EdgeCandidates=EdgeCandidates,
    )
