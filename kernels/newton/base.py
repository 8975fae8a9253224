"""The base that the first iterate of Newton's method is compared with, which has none before it.

Each body goes on as it moves, pushed as a whole by all that acts on it from outside. In a drift,
the other base, it stops to deform and to turn too.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.contact.structs import make_contact_structs
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.newton.codes import NewtonScalar
from warp_softbody.kernels.precision import real

SUBJECT = "newton_base"


@cache
def make_newton_base(precision: str) -> SimpleNamespace:
    """Kernels ``find_base`` and ``take_share``."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    kernel, func = types.kernel(SUBJECT), types.func(SUBJECT)
    MatrixRows = make_linear_structs(precision).MatrixRows
    VelocityUpdate = make_contact_structs(precision).VelocityUpdate

    @func
    def wide(a: vec3):
        return wp.vec3d(wp.float64(a[0]), wp.float64(a[1]), wp.float64(a[2]))

    @func
    def lacking(
        rows: MatrixRows,
        right: wp.array(dtype=vec3),
        known: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        share: wp.float64,
        drift: wp.vec3d,
        i: int,
    ):
        # what a node that drifts lacks, with a share of contact's impulses
        given = wide(right[i])
        if share > wp.float64(0.0):
            given += share * wide(known[i] - right[i])
        given += wp.float64(rows.masses[i]) * wide(before[i])
        return given - wp.float64(rows.damped_masses[i]) * drift

    @func
    def drift_of(
        body: int,
        body_start: wp.array(dtype=int),
        rows: MatrixRows,
        held: wp.array(dtype=int),
        right: wp.array(dtype=vec3),
        known: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        share: wp.float64,
    ):
        # velocity of a body that moves as a whole and does not turn: what acts on it from inside
        # cancels in the sum; of a body that is held, zero
        mass = wp.float64(0.0)
        total = wp.vec3d()
        for i in range(body_start[body], body_start[body + 1]):
            total += lacking(rows, right, known, before, share, wp.vec3d(), i)
            mass += wp.float64(rows.damped_masses[i])
            if held[i] != 0:
                mass = wp.float64(wp.inf)
        return total / mass

    @kernel
    def find_base(
        # model
        body_start: wp.array(dtype=int),
        rows: MatrixRows,
        # in
        held: wp.array(dtype=int),
        right: wp.array(dtype=vec3),
        moved: VelocityUpdate,
        # in and out
        known: wp.array(dtype=vec3),
        # out
        base: wp.array(dtype=vec3),
        drifting: wp.array(dtype=vec3),
        scalars: wp.array(dtype=wp.float64),
    ):
        # in one thread. A linearised step about a tangle may press on the ground without bound;
        # contact can bring about no more than what it stops or throws back, and what pushes it;
        # what strikes a body at the speed of a handle throws it back relative to that
        zero = wp.float64(0.0)
        fastest = zero
        for i in range(body_start[body_start.shape[0] - 1]):
            if held[i] != 0:
                speed_held = wide(moved.before[i]) + wide(moved.change[i])
                fastest = wp.max(fastest, wp.length(speed_held))
        half64 = wp.float64(0.5)
        share = wp.float64(1.0)
        alone = zero
        merit = zero
        for body in range(body_start.shape[0] - 1):
            drift = drift_of(body, body_start, rows, held, right, known, moved.before, zero)
            bound = zero
            pressed = zero
            for i in range(body_start[body], body_start[body + 1]):
                if held[i] == 0:
                    own = lacking(rows, right, known, moved.before, zero, drift, i)
                    bound += (
                        wp.float64(2.0) * wp.float64(rows.masses[i]) * (wp.length(drift) + fastest)
                    )
                    bound += half64 * wp.length(own)
                    alone += half64 * wp.dot(own, own) / wp.float64(rows.masses[i])
                    pressed += wp.length(wide(known[i] - right[i]))
            if not wp.isfinite(pressed):
                share = zero
            elif pressed > bound:
                share = wp.min(share, bound / pressed)
        scalars[NewtonScalar.SHARE] = share
        for body in range(body_start.shape[0] - 1):
            drift = drift_of(body, body_start, rows, held, right, known, moved.before, share)
            mass = zero
            momentum = wp.vec3d()
            for i in range(body_start[body], body_start[body + 1]):
                mass += wp.float64(rows.damped_masses[i])
                momentum += wp.float64(rows.damped_masses[i]) * wide(moved.before[i])
                if held[i] != 0:
                    mass = wp.float64(wp.inf)
            gain = drift - momentum / mass
            for i in range(body_start[body], body_start[body + 1]):
                base[i] = vec3(scalar(gain[0]), scalar(gain[1]), scalar(gain[2]))
                speed = vec3(scalar(drift[0]), scalar(drift[1]), scalar(drift[2]))
                drifting[i] = speed - moved.before[i]
                if held[i] != 0:
                    base[i] = moved.change[i]
                    drifting[i] = moved.change[i]
                else:
                    own = lacking(rows, right, known, moved.before, share, drift, i)
                    merit += half64 * wp.dot(own, own) / wp.float64(rows.masses[i])
                shared = right[i]
                if share > zero:
                    shared += scalar(share) * (known[i] - right[i])
                known[i] = shared
        scalars[NewtonScalar.DRIFT] = wp.sqrt(wp.max(alone, merit))

    @kernel
    def take_share(
        # in
        scalars: wp.array(dtype=wp.float64),
        values: wp.array(dtype=vec3),
        # out
        shared: wp.array(dtype=vec3),
    ):
        i = wp.tid()
        share = scalar(scalars[NewtonScalar.SHARE])
        shared[i] = vec3()
        if share > scalar(0.0):
            shared[i] = share * values[i]

    return SimpleNamespace(find_base=find_base, take_share=take_share)
