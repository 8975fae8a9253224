"""A warm solve of a step's contact QPCC as one kernel of native code, for processors.

It does what ``solve_qpcc`` with a start does, from the problem's arrays to the result's, or from
the step's maps that ``build_qpcc`` makes the problem of, in double precision and one thread, with
no Python between: the choice of modes is eliminated, its QP solved and its neighbours judged some
tens of times faster. What is out of the ordinary (contacts that are
redundant and agree, no point at all) it leaves to the NumPy form, which is the reference.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.control.active_set_system import KKT
from warp_softbody.kernels.control.contact_cones import CONES
from warp_softbody.kernels.control.contact_point import POINT
from warp_softbody.kernels.control.dual_active_set import ACTIVE_SET
from warp_softbody.kernels.control.mode_elimination import ELIMINATION
from warp_softbody.kernels.control.mode_search import SEARCH
from warp_softbody.kernels.control.mode_visits import VISITS
from warp_softbody.kernels.control.problem_scaling import SCALING
from warp_softbody.kernels.control.redundant_contacts import REDUNDANCE
from warp_softbody.kernels.control.search_layout import (
    COUNTS,
    MOST_OTHERS,
    NUMBERS,
    SearchFinding,
    SearchSizes,
)
from warp_softbody.kernels.control.step_assembly import ASSEMBLY
from warp_softbody.kernels.precision import real

SUBJECT = "contact_search"

LIMITS = {
    "GROWTH": "1e8",
    "REGULAR": "1e-3",
    "SINGULAR": "1e-10",
    "NOISE": "1e-6",
    "INCONSISTENT": "1e-7",
    "FAR": "1e300",
    "DEPENDENT": "1e-9",
    "VIOLATED": "1e-11",
    "ACCEPTED": "1e-9",
    "TINY": "1e-14",
    "FRICTIONLESS": "1e-9",
    "COLLINEAR": "1e-12",
    "TOUCHING": "1e-7",
    "SLOPE_NOISE": "1e-6",
    "PROGRESS": "1e-10",
    "ROUNDING": "1e-13",
    "WORTH": "0.5",
    "AT_BOUND": "1e-9",
    "CLEAR": "1e-9",
    "SHORTEST": "0.5",
    "CANCELS": "1e-4",
}
"""Constants of the native code; those of the NumPy form have its names."""

TOOLS = """
    static double size_of(double a) { return a < 0.0 ? -a : a; }
    static double max_of(double a, double b) { return a > b ? a : b; }
    static double min_of(double a, double b) { return a < b ? a : b; }
    static double root_of(double a) { return __builtin_sqrt(a); }
    static void exchange(double& a, double& b) {
        const double kept = a;
        a = b;
        b = kept;
    }
    APART static void copy(int n, const double* from, double* to) {
        for (int i = 0; i < n; ++i) to[i] = from[i];
    }
    APART static void copy_whole(int n, const int* from, int* to) {
        for (int i = 0; i < n; ++i) to[i] = from[i];
    }
    APART static void add(int n, double share, const double* __restrict__ from,
                          double* __restrict__ to) {
        for (int i = 0; i < n; ++i) to[i] += share * from[i];
    }
    APART static double dot(int n, const double* __restrict__ a, const double* __restrict__ b) {
        double sum = 0.0;
        for (int i = 0; i < n; ++i) sum += a[i] * b[i];
        return sum;
    }
"""

SCALARS = """
    double constant, reach, speed, impulse, value_scale, base_value, dual_residual;
    double objective, complementarity, feasibility, kkt;
    double dual;
    int p, count, size, rounds, qps, visits, failed;
    int c, w, wide, has_start, most_qps, kicks, patience, kick_held, assembles;
    int given_others, exploring;
"""

RUN = """
    void run(const int* given) {
        c = 3 * K;
        w = 1 + nu;
        wide = q + (K * r < nu ? K * r : nu) + 1;
        has_start = given[0];
        most_qps = given[1];
        kicks = given[2];
        patience = given[3];
        kick_held = given[4];
        assembles = given[5];
        given_others = given[6];
        findings[STATUS] = 1;
        if (assembles && !assemble()) return;
        constant = scalars[0];
        reach = scalars[1];
        qps = visits = failed = exploring = 0;
        build_cones();
        scale_problem();
        for (int j = 0; j < nu; ++j) inverse[j] = 1.0 / curve[j];
        const int best = search();
        findings[STATUS] = failed || best < 0;
        if (findings[STATUS]) return;
        copy_whole(nu, visit_bounds + best * nu, at_bound);
        finish(best);
        findings[QPS] = qps;
        findings[BEST] = best;
        findings[STATIONARY] = stationary[best];
        findings[COMPLETE] = complete[best];
        findings[NEXT] = keep_next(best);
        const double all[7] = {objective, complementarity, feasibility, kkt, speed, impulse,
                               value_scale};
        copy(7, all, results);
    }
"""


def _program() -> str:
    """The body of the native function."""
    sizes = "".join(f"    int {name};\n" for name in SearchSizes._fields)
    arrays = "".join(f"    double* {name};\n" for name in NUMBERS)
    arrays += "".join(f"    int* {name};\n" for name in COUNTS)
    members = [TOOLS, ASSEMBLY, CONES, SCALING, ELIMINATION, REDUNDANCE, KKT, ACTIVE_SET, VISITS]
    members += [SEARCH, POINT, RUN]
    constants = "".join(
        f"    constexpr double {name} = {value};\n" for name, value in LIMITS.items()
    )
    constants += "    constexpr int SLIDE = 2, COMMON = 4, MOST_ROUNDS = 2000;\n"
    constants += f"    constexpr int MOST_OTHERS = {MOST_OTHERS};\n"
    constants += "".join(f"    constexpr int {f.name} = {int(f)};\n" for f in SearchFinding)
    homes = [(name, "numbers") for name in NUMBERS] + [(name, "counts") for name in COUNTS]
    begin = [f"    one.{name} = given[{i}];\n" for i, name in enumerate(SearchSizes._fields)]
    begin += [
        f"    one.{name} = {home}.data + place[{i}];\n" for i, (name, home) in enumerate(homes)
    ]
    return (
        "#pragma clang fp reassociate(on) contract(fast)\n"
        "    #define APART __attribute__((noinline))\n"
        f"{constants}    struct Search {{\n{sizes}{arrays}{SCALARS}{''.join(members)}    }};\n"
        "    const int* place = places.data;\n"
        f"    const int* given = counts.data + place[{len(NUMBERS)}];\n"
        f"    Search one;\n{''.join(begin)}"
        f"    one.run(given + {len(SearchSizes._fields)});\n"
    )


@cache
def make_contact_search() -> SimpleNamespace:
    """The kernel ``solve``, launched over one item."""
    types = real("float64")
    kernel = types.kernel(SUBJECT)

    @types.native(_program())
    def solve_all(
        places: wp.array(dtype=int),
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ): ...

    @kernel
    def solve(
        # in
        places: wp.array(dtype=int),
        # in and out
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ):
        solve_all(places, counts, numbers)

    return SimpleNamespace(solve=solve)
