"""Structs of kernel arguments that belong together in a turning step."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "flight"


@cache
def make_flight_structs(precision: str) -> SimpleNamespace:
    """Structs of bodies and nodes, of how bodies spin, and of the frames that turn with them."""
    types = real(precision)
    scalar, vec3 = types.scalar, types.vec3
    vec3d, mat33d = wp.vec3d, wp.mat33d

    @wp.struct
    class FlightBodies:
        """What stays constant: first node of each body, masses of nodes, kg, and the step's."""

        node_start: wp.array(dtype=int)
        mass: wp.array(dtype=scalar)
        damped_mass: wp.array(dtype=scalar)
        gravity: wp.array(dtype=vec3)
        step_factors: wp.array(dtype=scalar)

    @wp.struct
    class StepStart:
        """Nodes at the start of a step, and impulses on them, N s: outer ones, and of pairs.

        Without pairs there are no ``pushes``, which kernels see.
        """

        positions: wp.array(dtype=vec3)
        velocities: wp.array(dtype=vec3)
        outer_impulses: wp.array(dtype=vec3)
        pushes: wp.array(dtype=vec3)

    @wp.struct
    class StepEnd:
        """Nodes at the end of a step, and what it added to their velocities."""

        positions: wp.array(dtype=vec3)
        velocities: wp.array(dtype=vec3)
        increments: wp.array(dtype=vec3)

    @wp.struct
    class Spins:
        """Bodies at the start of a step as if they were rigid.

        Centre of mass and its velocity; about it the angular momentum, what the impulses of the
        step add to that, and the inertia.
        """

        centers: wp.array(dtype=vec3d)
        drifts: wp.array(dtype=vec3d)
        momenta: wp.array(dtype=vec3d)
        torques: wp.array(dtype=vec3d)
        inertias: wp.array(dtype=mat33d)

    @wp.struct
    class Frames:
        """Frames of bodies: their rates, rad/s, and rigid turns that velocities are rid of.

        ``spins`` are those of the step's start, ``spares`` what Coriolis' turn adds to them,
        ``eulers`` Euler's load and ``answers`` that of the impulses, as rates.
        """

        rates: wp.array(dtype=vec3d)
        spins: wp.array(dtype=vec3d)
        spares: wp.array(dtype=vec3d)
        eulers: wp.array(dtype=vec3d)
        answers: wp.array(dtype=vec3d)

    return SimpleNamespace(
        FlightBodies=FlightBodies,
        StepStart=StepStart,
        StepEnd=StepEnd,
        Spins=Spins,
        Frames=Frames,
    )
