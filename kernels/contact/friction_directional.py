"""Friction that depends on the direction of sliding in the body's own frame."""

from typing import Any

import warp as wp

from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.precision import real


def constant_factor(precision: str, subject: str) -> Any:
    """The function ``friction_factor`` of a body whose friction is the same in all directions."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    GroundContacts = make_contact_structs(precision).GroundContacts

    @types.func(subject)
    def friction_factor(
        c: int,
        i: int,
        n: vec3,
        way: vec3,
        ground: GroundContacts,
        node_rotations: wp.array(dtype=mat33),
    ):
        return scalar(1.0)

    return friction_factor


def directional_factor(precision: str, subject: str) -> Any:
    """The function ``friction_factor``: linear in the angle between the factors given.

    The angle runs from the node's forward direction, turned with the node and laid into the plane
    of contact, counter-clockwise around the ground's normal. A node whose forward direction stands
    on the ground has no way of its own and takes the mean.
    """
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    GroundContacts = make_contact_structs(precision).GroundContacts
    turn = wp.constant(scalar(6.283185307179586))

    @types.func(subject)
    def friction_factor(
        c: int,
        i: int,
        n: vec3,
        way: vec3,
        ground: GroundContacts,
        node_rotations: wp.array(dtype=mat33),
    ):
        factors = ground.friction_factors
        directions = factors.shape[1]
        ahead = node_rotations[i] * ground.forward[c]
        ahead = ahead - wp.dot(n, ahead) * n
        if wp.length(ahead) < scalar(1e-3):
            mean = scalar(0.0)
            for k in range(directions):
                mean += factors[c, k]
            return mean / scalar(directions)
        angle = wp.atan2(wp.dot(wp.cross(n, ahead), way), wp.dot(ahead, way))
        if angle < scalar(0.0):
            angle += turn
        place = angle * (scalar(directions) / turn)
        low = int(place)
        part = place - scalar(low)
        first = factors[c, low % directions]
        return first + part * (factors[c, (low + 1) % directions] - first)

    return friction_factor
