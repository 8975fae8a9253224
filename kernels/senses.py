"""What an environment observes of a body, as native code for processors.

`environment.senses` has it in units of the body; NumPy has the same in its test.
"""

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "senses"

Shape = Callable[[int, int, int, int, int, int], tuple[int, ...]]

NUMBERS: dict[str, Shape] = {
    # m and m a of each node, a being its arm about the centre of mass at rest
    "moments": lambda n, s, m, g, k, c: (n, 4),
    "positions": lambda n, s, m, g, k, c: (n, 3),
    "velocities": lambda n, s, m, g, k, c: (n, 3),
    # impulses of the ground along z
    "borne": lambda n, s, m, g, k, c: (c,),
    # of the corners around either end of a segment, those of the first end being negative
    "weights": lambda n, s, m, g, k, c: (s, 8),
    # sums of m r and of m a r
    "sums": lambda n, s, m, g, k, c: (4, 3),
    "momentum": lambda n, s, m, g, k, c: (3,),
    # angular momentum about the centre of mass
    "spin": lambda n, s, m, g, k, c: (3,),
    "lengths": lambda n, s, m, g, k, c: (m,),
    "loads": lambda n, s, m, g, k, c: (g,),
}
"""Arrays of double precision for n nodes, s segments of m muscles, and g feet with k of the c nodes
that may touch the ground."""

COUNTS: dict[str, Shape] = {
    "sizes": lambda n, s, m, g, k, c: (4,),
    "corners": lambda n, s, m, g, k, c: (s, 8),
    "muscles": lambda n, s, m, g, k, c: (s,),
    "starts": lambda n, s, m, g, k, c: (g + 1,),
    "members": lambda n, s, m, g, k, c: (k,),
}
"""Arrays of whole numbers; ``starts`` says where the nodes of each foot begin."""

BEGIN = "".join(
    f"    double* {name} = numbers.data + places.data[{i}];\n" for i, name in enumerate(NUMBERS)
) + "".join(
    f"    const int* {name} = counts.data + places.data[{len(NUMBERS) + i}];\n"
    for i, name in enumerate(COUNTS)
)

SENSES = """
    const int n = sizes[0], s = sizes[1], m = sizes[2], g = sizes[3];
    double mass = 0.0, turn[3] = {0.0, 0.0, 0.0}, middle[3];
    for (int a = 0; a < 12; ++a) sums[a] = 0.0;
    for (int a = 0; a < 3; ++a) momentum[a] = 0.0;
    for (int i = 0; i < n; ++i) {
        const double *x = positions + 3 * i, *v = velocities + 3 * i, *moment = moments + 4 * i;
        mass += moment[0];
        for (int b = 0; b < 4; ++b)
            for (int a = 0; a < 3; ++a) sums[3 * b + a] += moment[b] * x[a];
        for (int a = 0; a < 3; ++a) momentum[a] += moment[0] * v[a];
    }
    for (int a = 0; a < 3; ++a) middle[a] = sums[a] / mass;
    for (int i = 0; i < n; ++i) {
        const double *v = velocities + 3 * i;
        double arm[3];
        for (int a = 0; a < 3; ++a) arm[a] = moments[4 * i] * (positions[3 * i + a] - middle[a]);
        turn[0] += arm[1] * v[2] - arm[2] * v[1];
        turn[1] += arm[2] * v[0] - arm[0] * v[2];
        turn[2] += arm[0] * v[1] - arm[1] * v[0];
    }
    for (int a = 0; a < 3; ++a) spin[a] = turn[a];
    for (int k = 0; k < m; ++k) lengths[k] = 0.0;
    for (int k = 0; k < s; ++k) {
        double way[3] = {0.0, 0.0, 0.0};
        for (int c = 0; c < 8; ++c)
            for (int a = 0; a < 3; ++a)
                way[a] += weights[8 * k + c] * positions[3 * corners[8 * k + c] + a];
        lengths[muscles[k]] += sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    }
    for (int k = 0; k < g; ++k) {
        loads[k] = 0.0;
        for (int i = starts[k]; i < starts[k + 1]; ++i) loads[k] += borne[members[i]];
    }
"""


@cache
def make_senses() -> SimpleNamespace:
    """The kernel ``observe``, launched over one item."""
    types = real("float64")
    kernel = types.kernel(SUBJECT)

    @types.native(BEGIN + SENSES)
    def senses_of(
        places: wp.array(dtype=int),
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ): ...

    @kernel
    def observe(
        # in
        places: wp.array(dtype=int),
        # in and out
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ):
        senses_of(places, counts, numbers)

    return SimpleNamespace(observe=observe)
