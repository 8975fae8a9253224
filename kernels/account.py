"""What the steps of a run did to the momentum of each body, and what contact did to its energy.

Elastic and muscle forces have no net force, so a body's momentum changes by gravity, outer forces,
damping of its mass and the impulses of contact; what is left over is the step's error. Contact may
hold and brake, but not drive: friction never works along the velocity, and a normal impulse never
pulls. All of it is summed on the device, and read once, at the end.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real
from warp_softbody.kernels.widening import make_widening

SUBJECT = "account"


@cache
def make_account(precision: str) -> SimpleNamespace:
    """Kernels ``balance_bodies``, ``add_ground``, ``add_pairs`` and ``find_shapes``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    wide = make_widening(precision, SUBJECT).wide
    vec3d = wp.vec3d

    @func
    def size_of(v: vec3d):
        return wp.abs(v[0]) + wp.abs(v[1]) + wp.abs(v[2])

    @func
    def is_held(first: int, last: int, fixed: wp.array(dtype=int)):
        # whether something outside of all forces holds a node of a body
        for i in range(first, last):
            if fixed[i] != 0:
                return True
        return False

    @kernel
    def balance_bodies(
        # model
        body_start: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        damped_masses: wp.array(dtype=scalar),
        fixed: wp.array(dtype=int),
        gravity: wp.array(dtype=vec3),
        step_factors: wp.array(dtype=scalar),
        # in
        outer_impulses: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        # out
        missing: wp.array(dtype=vec3d),
        exchanged: wp.array(dtype=wp.float64),
        energies: wp.array(dtype=wp.float64),
    ):
        # what forces other than contact fail to explain; a body that is held has no balance
        body = wp.tid()
        left = vec3d()
        given = vec3d()
        fall = wp.float64(step_factors[0]) * wide(gravity[0])
        energy = wp.float64(0.0)
        for i in range(body_start[body], body_start[body + 1]):
            m = wp.float64(masses[i])
            damped = wp.float64(damped_masses[i])
            last = before[i] + change[i]
            gained = wide(last) - wide(before[i])
            outer = m * fall + wide(outer_impulses[i])
            given += outer
            energy += m * wp.length_sq(wide(last))
            left += damped * gained + (damped - m) * wide(before[i]) - outer
        if is_held(body_start[body], body_start[body + 1], fixed):
            left = vec3d()
            given = vec3d()
        missing[body] = missing[body] + left
        exchanged[body] = exchanged[body] + size_of(given)
        energies[body] = wp.max(energies[body], wp.float64(0.5) * energy)

    @kernel
    def add_ground(
        # model
        body_start: wp.array(dtype=int),
        contact_start: wp.array(dtype=int),
        surface_nodes: wp.array(dtype=int),
        fixed: wp.array(dtype=int),
        # in
        modes: wp.array(dtype=int),
        impulses: wp.array(dtype=vec3),
        normals: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        # in and out
        missing: wp.array(dtype=vec3d),
        exchanged: wp.array(dtype=wp.float64),
        gains: wp.array(dtype=wp.float64),
    ):
        body = wp.tid()
        total = vec3d()
        work = wp.float64(0.0)
        for c in range(contact_start[body], contact_start[body + 1]):
            i = surface_nodes[c]
            if fixed[i] == 0 and wp.length_sq(impulses[c]) > scalar(0.0):
                impulse = wide(impulses[c])
                n = wide(normals[i])
                velocity = wide(before[i]) + wide(change[i])
                press = wp.dot(n, impulse)
                speed = wp.dot(n, velocity)
                total += impulse
                work += wp.max(wp.dot(impulse - press * n, velocity - speed * n), wp.float64(0.0))
                work += wp.max(-press, wp.float64(0.0)) * wp.abs(speed)
        if not is_held(body_start[body], body_start[body + 1], fixed):
            missing[body] = missing[body] - total
            exchanged[body] = exchanged[body] + size_of(total)
        gains[body] = gains[body] + work

    @types.kernel(SUBJECT, "pairs")
    def add_pairs(
        # model
        body_start: wp.array(dtype=int),
        fixed: wp.array(dtype=int),
        # in
        found: wp.array(dtype=int),
        found_count: wp.array(dtype=int),
        nodes: wp.array(dtype=wp.vec4i),
        impulses: wp.array(dtype=vec3),
        # in and out
        missing: wp.array(dtype=vec3d),
        exchanged: wp.array(dtype=wp.float64),
    ):
        # onto one side, and the opposite onto the other, whose node is the third
        body = wp.tid()
        first = body_start[body]
        last = body_start[body + 1]
        if is_held(first, last, fixed):
            return
        total = vec3d()
        for number in range(found_count[0]):
            c = found[number]
            one = nodes[c][0]
            other = nodes[c][2]
            if one >= first and one < last:
                total += wide(impulses[c])
            # the ground, on the other side, has the first node there again
            if other != one and other >= first and other < last:
                total -= wide(impulses[c])
        missing[body] = missing[body] - total
        exchanged[body] = exchanged[body] + size_of(total)

    @kernel
    def find_shapes(
        # model
        tet_start: wp.array(dtype=int),
        tets: wp.array(dtype=wp.vec4i),
        # in
        positions: wp.array(dtype=vec3),
        # out
        volumes: wp.array(dtype=wp.float64),
        least: wp.array(dtype=wp.float64),
        largest: wp.array(dtype=wp.float64),
        inverted: wp.array(dtype=int),
        most_inverted: wp.array(dtype=int),
    ):
        # of a body: its volume, tets inside out, and the extremes so far
        body = wp.tid()
        total = wp.float64(0.0)
        count = int(0)
        for t in range(tet_start[body], tet_start[body + 1]):
            k = tets[t]
            a = wide(positions[k[0]])
            along = wp.cross(wide(positions[k[1]]) - a, wide(positions[k[2]]) - a)
            sixfold = wp.dot(along, wide(positions[k[3]]) - a)
            total += sixfold / wp.float64(6.0)
            if not sixfold > wp.float64(0.0):
                count += 1
        volumes[body] = total
        least[body] = wp.min(least[body], total)
        largest[body] = wp.max(largest[body], total)
        inverted[body] = count
        most_inverted[body] = wp.max(most_inverted[body], count)

    return SimpleNamespace(
        balance_bodies=balance_bodies,
        add_ground=add_ground,
        add_pairs=add_pairs,
        find_shapes=find_shapes,
    )
