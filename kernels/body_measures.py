"""What controllers ask of a body in every step, as native code for processors: its momenta.

NumPy has the same in ``world.view`` and ``controllers.objectives``, which is the reference.
"""

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "body_measures"

Shape = Callable[[int, int], tuple[int, ...]]

NUMBERS: dict[str, Shape] = {
    "masses": lambda n, f: (n,),
    "positions": lambda n, f: (n, 3),
    "velocities": lambda n, f: (n, 3),
    # centre of mass, linear and angular momentum
    "momenta": lambda n, f: (3, 3),
    # what takes velocities to the angular momentum
    "turning": lambda n, f: (3, n, 3),
    # two directions along the ground, an area along it and its gradient
    "ground": lambda n, f: (2, 3),
    "area": lambda n, f: (1,),
    "gradient": lambda n, f: (n, 3),
}
"""Arrays of double precision for n nodes and f triangles of a base."""

COUNTS: dict[str, Shape] = {"sizes": lambda n, f: (2,), "triangles": lambda n, f: (f, 3)}
"""Arrays of whole numbers."""

BEGIN = "".join(
    f"    double* {name} = numbers.data + places.data[{i}];\n" for i, name in enumerate(NUMBERS)
) + "".join(
    f"    const int* {name} = counts.data + places.data[{len(NUMBERS) + i}];\n"
    for i, name in enumerate(COUNTS)
)

MOMENTA = """
    const int n = sizes[0];
    double mass = 0.0, *centre = momenta, *linear = momenta + 3, *angular = momenta + 6;
    for (int a = 0; a < 9; ++a) momenta[a] = 0.0;
    for (int i = 0; i < n; ++i) {
        mass += masses[i];
        for (int a = 0; a < 3; ++a) {
            centre[a] += masses[i] * positions[3 * i + a];
            linear[a] += masses[i] * velocities[3 * i + a];
        }
    }
    for (int a = 0; a < 3; ++a) centre[a] /= mass;
    double *first = turning, *second = turning + 3 * n, *third = turning + 6 * n;
    for (int i = 0; i < n; ++i) {
        const double* v = velocities + 3 * i;
        double arm[3];
        for (int a = 0; a < 3; ++a) arm[a] = (positions[3 * i + a] - centre[a]) * masses[i];
        first[3 * i + 1] = -arm[2];
        first[3 * i + 2] = arm[1];
        second[3 * i] = arm[2];
        second[3 * i + 2] = -arm[0];
        third[3 * i] = -arm[1];
        third[3 * i + 1] = arm[0];
        angular[0] += arm[1] * v[2] - arm[2] * v[1];
        angular[1] += arm[2] * v[0] - arm[0] * v[2];
        angular[2] += arm[0] * v[1] - arm[1] * v[0];
    }
"""

AREA = """
    const int n = sizes[0], f = sizes[1];
    for (int i = 0; i < 3 * n; ++i) gradient[i] = 0.0;
    area[0] = 0.0;
    for (int i = 0; i < f; ++i) {
        double flat[3][2], turned[3][2], doubled = 0.0;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < 2; ++t) {
                const double *x = positions + 3 * triangles[3 * i + c], *way = ground + 3 * t;
                flat[c][t] = x[0] * way[0] + x[1] * way[1] + x[2] * way[2];
            }
        for (int c = 0; c < 3; ++c) {
            const double *ahead = flat[(c + 1) % 3], *behind = flat[(c + 2) % 3];
            turned[c][0] = ahead[1] - behind[1];
            turned[c][1] = behind[0] - ahead[0];
            doubled += 0.5 * (flat[c][0] * turned[c][0] + flat[c][1] * turned[c][1]);
        }
        const double sign = doubled > 0.0 ? 1.0 : doubled < 0.0 ? -1.0 : 0.0;
        area[0] += sign * doubled;
        for (int c = 0; c < 3; ++c)
            for (int a = 0; a < 3; ++a)
                gradient[3 * triangles[3 * i + c] + a]
                    += sign * (turned[c][0] * ground[a] + turned[c][1] * ground[3 + a]);
    }
"""


@cache
def make_body_measures() -> SimpleNamespace:
    """The kernels ``find_momenta`` and ``find_area``, each launched over one item."""
    types = real("float64")
    kernel = types.kernel(SUBJECT)

    @types.native(BEGIN + MOMENTA)
    def momenta_of(
        places: wp.array(dtype=int),
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ): ...

    @kernel
    def find_momenta(
        # in
        places: wp.array(dtype=int),
        # in and out
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ):
        momenta_of(places, counts, numbers)

    @types.native(BEGIN + AREA)
    def area_of(
        places: wp.array(dtype=int),
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ): ...

    @kernel
    def find_area(
        # in
        places: wp.array(dtype=int),
        # in and out
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ):
        area_of(places, counts, numbers)

    return SimpleNamespace(find_momenta=find_momenta, find_area=find_area)
