"""Coulomb's law with a cone of k directions: friction that dissipates most over a polygon.

The polygon of a node has its corners g d_j, g = mu f_n from the last pass, on k directions d_j
evenly spread in the plane of contact from its first tangent, which lies along x where possible. Its
2 k places are numbered around: corner j is 2 j, the edge from there to corner j + 1 is 2 j + 1. At
a corner the friction is that corner. On an edge the velocity along the edge is given, zero, and the
friction is the edge's distance from the middle times g, across it, with what holds the node along
it. Where g or the place has changed much since the last pass, that part enters as stiffness, force
over speed, which cannot reverse the sliding.
"""

import math
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.modes import (
    BEYOND,
    LAST_PASSES,
    MISSED,
    NEWTON_PASSES,
    SETTLED,
    Mode,
)
from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.precision import real


def make_polygon_law(precision: str, subject: str, directions: int) -> SimpleNamespace:
    """Functions ``constraint_of``, ``coulomb_violation``, ``choose``; ``inner_radius``."""
    types = real(precision)
    scalar, vec3, mat33 = types.scalar, types.vec3, types.mat33
    func = types.func(subject)
    Tolerances = make_contact_structs(precision).Tolerances
    newton_passes, last_passes = wp.constant(NEWTON_PASSES), wp.constant(LAST_PASSES)
    beyond_share, nearly = wp.constant(scalar(BEYOND)), wp.constant(scalar(SETTLED))
    missed_share = wp.constant(scalar(MISSED))
    count = wp.constant(2 * directions)
    half_turn = math.pi / directions
    step = wp.constant(scalar(half_turn))
    apothem = wp.constant(scalar(math.cos(half_turn)))
    half_edge = wp.constant(scalar(math.sin(half_turn)))

    @func
    def first_tangent(n: vec3):
        axis = vec3(scalar(1.0), scalar(0.0), scalar(0.0))
        if wp.abs(n[0]) >= scalar(0.9):
            axis = vec3(scalar(0.0), scalar(1.0), scalar(0.0))
        return wp.normalize(axis - wp.dot(axis, n) * n)

    @func
    def direction_of(place: int, n: vec3):
        first = first_tangent(n)
        angle = step * scalar(place)
        return wp.cos(angle) * first + wp.sin(angle) * wp.cross(n, first)

    @func
    def constraint_of(mode: int, n: vec3):
        # the velocity constraint of a sliding node, and the axis that goes with it
        kind = VelocityConstraint.PLANE
        axis = n
        if mode >= Mode.PLACE and (mode - Mode.PLACE) % 2 == 1:
            kind = VelocityConstraint.LINE
            axis = direction_of(mode - Mode.PLACE, n)
        return kind, axis

    @func
    def nearest_place(trial: vec3, bound: scalar, n: vec3):
        # the place of the polygon nearest to the trial, how far the trial is beyond that edge (or
        # one that ends in that corner), and the nearest point of the polygon
        first = first_tangent(n)
        angle = wp.atan2(wp.dot(wp.cross(n, first), trial), wp.dot(first, trial))
        place = 2 * int(wp.floor(angle / (scalar(2.0) * step))) + 1
        place = (place + count) % count
        across = direction_of(place, n)
        beyond = wp.dot(across, trial) - apothem * bound
        nearest = trial
        if beyond > scalar(0.0):
            along = wp.cross(n, across)
            aside = wp.dot(along, trial)
            if wp.abs(aside) > half_edge * bound:
                place = place + wp.where(aside > scalar(0.0), 1, count - 1)
                place = place % count
                nearest = bound * direction_of(place, n)
            else:
                nearest = apothem * bound * across + aside * along
        return place, beyond, nearest

    @func
    def coulomb_violation(n: vec3, friction: vec3, trial: vec3, bound: scalar):
        # distance of the friction from the projection of the trial onto the polygon
        _place, _beyond, nearest = nearest_place(trial, bound, n)
        return wp.length(friction - nearest)

    @func
    def neighbour(
        place: int,
        n: vec3,
        friction: vec3,
        sliding: vec3,
        last: vec3,
        bound: scalar,
        margin: scalar,
        slowest: scalar,
    ):
        # the place after ``place``; -1 to stick
        across = direction_of(place, n)
        along = wp.cross(n, across)
        ahead = -wp.dot(across, sliding)
        # friction that would reverse the sliding stops it instead
        if wp.length(sliding) <= slowest or wp.dot(last, sliding) < scalar(0.0):
            return -1
        if place % 2 == 1:
            if ahead <= scalar(0.0):
                return -1
            aside = wp.dot(along, friction)
            if wp.abs(aside) > half_edge * bound + margin:
                return (place + wp.where(aside > scalar(0.0), 1, count - 1)) % count
            return place
        aside = -wp.dot(along, sliding)
        outside = wp.abs(aside) * apothem - ahead * half_edge
        if outside > slowest + scalar(1e-3) * wp.length(sliding):
            # to the last edge before the corner whose cone of normals holds the velocity, so that
            # a node does not jump to and fro across an edge
            corners = wp.atan2(wp.abs(aside), ahead) / (scalar(2.0) * step)
            edges = 2 * wp.max(int(wp.floor(corners + scalar(0.5))), 1) - 1
            return (place + wp.where(aside > scalar(0.0), edges, count - edges)) % count
        return place

    @func
    def missed(place: int, n: vec3, friction: vec3, bound: scalar):
        # what the friction at a place lacks of the present bound
        across = direction_of(place, n)
        if place % 2 == 1:
            return wp.abs(wp.dot(across, friction) - apothem * bound)
        return wp.length(friction - bound * across)

    @func
    def choose(
        mode: int,
        n: vec3,
        friction: vec3,
        sliding: vec3,
        last: vec3,
        bound: scalar,
        weight: scalar,
        left: scalar,
        passes: int,
        tolerances: Tolerances,
    ):
        # next mode, whether the law is missed, force, stiffness, velocity they are made at
        unsettled = int(0)
        place = int(-1)
        # to begin, it must exceed the cone by what would move its own block noticeably
        margin = (
            wp.min(weight * tolerances.sliding_speed, beyond_share * bound) + tolerances.impulse
        )
        trial = friction - weight * sliding
        found, beyond, _nearest = nearest_place(trial, bound, n)
        next_mode = int(Mode.STICK)
        if mode == Mode.STICK:
            # late in a step only what the law does not allow by far begins
            if passes >= newton_passes:
                margin += missed_share * bound
            if beyond > margin and passes < last_passes:
                place = found
        elif bound <= tolerances.impulse:
            next_mode = Mode.SLIDE
        elif mode == Mode.SLIDE:
            if beyond > scalar(0.0) and wp.length(sliding) > tolerances.sliding_speed:
                place = found
        else:
            margin = beyond_share * bound + tolerances.impulse + left
            place = neighbour(
                mode - Mode.PLACE,
                n,
                friction,
                sliding,
                last,
                bound,
                margin,
                tolerances.sliding_speed,
            )
            if place == mode - Mode.PLACE:
                lacks = missed(place, n, friction, bound)
                if lacks > missed_share * bound + tolerances.impulse + left:
                    unsettled = 1
        force = vec3()
        stiffness = mat33()
        made_at = sliding
        if mode == Mode.STICK:
            # where it is driven; its speed is not known yet
            made_at = (scalar(-1.0) / weight) * trial
        if place >= 0:
            next_mode = Mode.PLACE + place
            across = direction_of(place, n)
            size = wp.where(place % 2 == 1, apothem, scalar(1.0)) * bound
            speed = wp.max(-wp.dot(across, sliding), tolerances.sliding_speed)
            before = -wp.dot(across, last)
            settled = before > nearly * speed and speed > nearly * before
            near = missed(place, n, friction, bound) < bound and passes < last_passes
            if mode == Mode.STICK or settled or near:
                force = size * across
            else:
                stiffness = (size / speed) * wp.outer(across, across)
        return next_mode, unsettled, force, stiffness, made_at

    return SimpleNamespace(
        constraint_of=constraint_of,
        coulomb_violation=coulomb_violation,
        choose=choose,
        inner_radius=math.cos(math.pi / directions),
    )
