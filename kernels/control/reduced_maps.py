"""One step's linear maps out of rows of J and of what is known of them, for processors.

Two kernels of native code stand before and after the solve of M~ W = J^T. The first takes rows
apart: it keeps what is not zero, tells momenta, which need no solve, and writes the others to
blocks of 16 right-hand sides. The second puts J W, J v+ and the map of muscles together. Most rows
are means over a few nodes along an axis, of which a product has little to add up.
"""

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import NamedTuple

import warp as wp

from warp_softbody.kernels.precision import BLOCK, real

SUBJECT = "reduced_maps"

SAME = 1e-9
"""Relative difference up to which the entries of a row are one direction times the masses."""


class MapSizes(NamedTuple):
    """What the shapes of all arrays follow from, named as in the native code."""

    q: int
    """Rows that are given whole."""
    K: int
    """Patches, with three rows each."""
    n: int
    """Nodes."""
    s: int
    """Segments of muscles."""
    blocks: int
    """Blocks of right-hand sides that there is room for."""
    held: int
    """Whether nodes are fixed, so that no row is a momentum."""

    @property
    def r(self) -> int:
        """Rows of J."""
        return self.q + 3 * self.K


Shape = Callable[[MapSizes], tuple[int, ...]]

NUMBERS: dict[str, Shape] = {
    "rows": lambda a: (a.q, 3 * a.n),
    "weights": lambda a: (a.K, a.n),
    "frames": lambda a: (a.K, 3, 3),
    "masses": lambda a: (a.n,),
    "scalars": lambda a: (2,),
    # of the rows: what is not zero, sums by axis, and the answer d / (1 + dt mu) of momenta
    "entry": lambda a: (a.r, 3 * a.n),
    "sums": lambda a: (a.r, 3),
    "shift": lambda a: (a.r, 3),
    "line": lambda a: (3 * a.n,),
    "product": lambda a: (a.r, a.blocks * BLOCK),
    # of the step
    "compliance": lambda a: (a.r, a.r),
    "free_velocity": lambda a: (a.r,),
    "muscle_map": lambda a: (a.r, a.s),
    "lengths": lambda a: (a.s,),
    "reaches": lambda a: (a.s,),
}
"""Arrays of double precision, one after the other; ``scalars`` are mass and 1 / (1 + dt mu)."""

COUNTS: dict[str, Shape] = {
    "settings": lambda a: (len(MapSizes._fields),),
    "solved": lambda a: (2,),
    "number": lambda a: (a.r,),
    "place": lambda a: (a.r, 3 * a.n),
    # of a row among the right-hand sides; -1 for a momentum
    "column": lambda a: (a.r,),
}
"""Arrays of whole numbers; ``solved`` are the rows to solve for, and whether all numbers are
finite: of the rows, then of the maps."""

TOOLS = f"""
    static double size_of(double a) {{ return a < 0.0 ? -a : a; }}
    static double max_of(double a, double b) {{ return a > b ? a : b; }}

    // Whether three numbers a node are a direction times its mass, which ``to`` then has.
    APART bool is_momentum(const double* row, double* to) {{
        const double *first = row, *last = row + 3 * (n - 1);
        double size = 0.0, apart = 0.0;
        for (int a = 0; a < 3; ++a) {{
            const double one = first[a] / masses[0];
            size = max_of(size, size_of(one));
            const double off = size_of(last[a] / masses[n - 1] - one);
            if (!(off <= {SAME} * 1e300)) return false;
            apart = max_of(apart, off);
        }}
        // most rows are told apart by two nodes
        if (!(apart <= {SAME} * size && size > 0.0)) return false;
        double sum[3] = {{}}, largest = 0.0, miss = 0.0;
        for (int i = 0; i < n; ++i)
            for (int a = 0; a < 3; ++a) sum[a] += row[3 * i + a];
        for (int a = 0; a < 3; ++a) {{
            sum[a] /= scalars[0];
            largest = max_of(largest, size_of(sum[a]));
        }}
        for (int i = 0; i < n; ++i)
            for (int a = 0; a < 3; ++a)
                miss = max_of(miss, size_of(row[3 * i + a] / masses[i] - sum[a]));
        if (!(miss <= {SAME} * largest)) return false;
        for (int a = 0; a < 3; ++a) to[a] = sum[a] * scalars[1];
        return true;
    }}
"""

GATHER = """
    // What is not zero of a row (3n,), and its sums by axis.
    APART void keep_whole(int i, const double* row) {
        double* own = entry + (size_t)3 * n * i;
        int *where = place + (size_t)3 * n * i, count = 0;
        double sum[3] = {};
        for (int k = 0; k < n; ++k) {
            const double x = row[3 * k], y = row[3 * k + 1], z = row[3 * k + 2];
            if (x == 0.0 && y == 0.0 && z == 0.0) continue;
            sum[0] += x;
            sum[1] += y;
            sum[2] += z;
            for (int a = 0; a < 3; ++a) {
                own[count] = row[3 * k + a];
                where[count] = 3 * k + a;
                count += row[3 * k + a] != 0.0;
            }
        }
        number[i] = count;
        for (int a = 0; a < 3; ++a) sums[3 * i + a] = sum[a];
    }

    // The same of the three rows of patch k: its axes times the weights of its nodes.
    APART void keep_patch(int k) {
        const double *weight = weights + (size_t)k * n, *axes = frames + 9 * k;
        double total = 0.0;
        for (int i = q + 3 * k; i < q + 3 * k + 3; ++i) number[i] = 0;
        for (int j = 0; j < n; ++j) {
            if (weight[j] == 0.0) continue;
            total += weight[j];
            for (int t = 0; t < 3; ++t) {
                const int i = q + 3 * k + t;
                double* own = entry + (size_t)3 * n * i;
                int *where = place + (size_t)3 * n * i, count = number[i];
                for (int a = 0; a < 3; ++a) {
                    own[count] = axes[3 * t + a] * weight[j];
                    where[count] = 3 * j + a;
                    count += own[count] != 0.0;
                }
                number[i] = count;
            }
        }
        for (int t = 0; t < 3; ++t)
            for (int a = 0; a < 3; ++a) sums[3 * (q + 3 * k + t) + a] = axes[3 * t + a] * total;
    }

    bool patch_is_momentum(int i) {
        const int k = (i - q) / 3, t = (i - q) % 3;
        const double* weight = weights + (size_t)k * n;
        const double one = weight[0] / masses[0], other = weight[n - 1] / masses[n - 1];
        if (!(one != 0.0 && other != 0.0)) return false;
        for (int j = 0; j < n; ++j)
            for (int a = 0; a < 3; ++a) line[3 * j + a] = frames[9 * k + 3 * t + a] * weight[j];
        return is_momentum(line, shift + 3 * i);
    }

    // Rows taken apart, and the blocks of those that are to be solved for.
    void gather(SCALAR* right) {
        for (int i = 0; i < q; ++i) keep_whole(i, rows + (size_t)3 * n * i);
        for (int k = 0; k < K; ++k) keep_patch(k);
        int columns = 0;
        double all = 0.0;
        for (int i = 0; i < q + 3 * K; ++i) {
            bool answered = false;
            if (!held)
                answered = i < q ? is_momentum(rows + (size_t)3 * n * i, shift + 3 * i)
                                 : patch_is_momentum(i);
            column[i] = answered ? -1 : columns++;
            for (int a = 0; a < 3; ++a) all += sums[3 * i + a];
        }
        solved[0] = columns;
        solved[1] = size_of(all) < 1e300;
        const int used = columns > LANES ? (columns + LANES - 1) / LANES : 1;
        for (size_t i = 0; i < (size_t)used * 3 * n * LANES; ++i) right[i] = 0;
        for (int i = 0; i < q + 3 * K; ++i) {
            if (column[i] < 0) continue;
            SCALAR* to = right + (size_t)(column[i] / LANES) * 3 * n * LANES + column[i] % LANES;
            const double* own = entry + (size_t)3 * n * i;
            const int* where = place + (size_t)3 * n * i;
            for (int e = 0; e < number[i]; ++e) to[(size_t)where[e] * LANES] = (SCALAR)own[e];
        }
    }
"""

CONCLUDE = """
    // J W for the rows that were solved for: sums over what of a row is not zero.
    APART void multiply(const lanes* X, int used) {
        for (int b = 0; b < used; ++b, X += 3 * n)
            for (int i = 0; i < q + 3 * K; ++i) {
                const double* own = entry + (size_t)3 * n * i;
                const int *where = place + (size_t)3 * n * i, count = number[i];
                wide one = {}, other = {};
                int e = 0;
                for (; e + 1 < count; e += 2) {
                    one += own[e] * __builtin_convertvector(X[where[e]], wide);
                    other += own[e + 1] * __builtin_convertvector(X[where[e + 1]], wide);
                }
                if (e < count) one += own[e] * __builtin_convertvector(X[where[e]], wide);
                *(wide*)(product + ((size_t)i * blocks + b) * LANES) = one + other;
            }
    }

    // Row i times the answer to row j.
    double answer(int i, int j) const {
        if (column[j] >= 0) return product[(size_t)i * blocks * LANES + column[j]];
        const double *own = sums + 3 * i, *way = shift + 3 * j;
        return own[0] * way[0] + own[1] * way[1] + own[2] * way[2];
    }

    void conclude(const SCALAR* x, const SCALAR* response, const SCALAR* maps,
                  const SCALAR* momentum, const SCALAR* length, const SCALAR* reach) {
        const int r = q + 3 * K, columns = solved[0];
        multiply((const lanes*)x, columns > 0 ? (columns + LANES - 1) / LANES : 0);
        double momenta[3] = {};
        for (int i = 0; i < n; ++i)
            for (int a = 0; a < 3; ++a) momenta[a] += momentum[3 * i + a];
        for (int i = 0; i < r; ++i) {
            for (int j = 0; j <= i; ++j)
                compliance[i * r + j] = compliance[j * r + i]
                    = 0.5 * (answer(i, j) + answer(j, i));
            const int own = column[i];
            double* to = muscle_map + (size_t)i * s;
            if (own < 0) {
                const double* way = shift + 3 * i;
                free_velocity[i] = way[0] * momenta[0] + way[1] * momenta[1] + way[2] * momenta[2];
                for (int j = 0; j < s; ++j) to[j] = 0.0;
            } else {
                const SCALAR* from = maps + (size_t)(own / LANES) * s * LANES + own % LANES;
                free_velocity[i] = response[own];
                for (int j = 0; j < s; ++j) to[j] = from[(size_t)j * LANES];
            }
        }
        double all = 0.0;
        for (int i = 0; i < r * r; ++i) all += compliance[i];
        for (int i = 0; i < r * s; ++i) all += muscle_map[i];
        for (int i = 0; i < r; ++i) all += free_velocity[i];
        solved[1] = size_of(all) < 1e300;
        for (int j = 0; j < s; ++j) {
            lengths[j] = length[j];
            reaches[j] = reach[j];
        }
    }
"""


def _program(call: str) -> str:
    """The body of a native function that calls a member of the local class."""
    members = "".join(f"    int {name};\n" for name in MapSizes._fields)
    members += "".join(f"    double* {name};\n" for name in NUMBERS)
    members += "".join(f"    int* {name};\n" for name in COUNTS)
    homes = [(name, "numbers") for name in NUMBERS] + [(name, "counts") for name in COUNTS]
    begin = [f"    one.{name} = given[{i}];\n" for i, name in enumerate(MapSizes._fields)]
    begin += [
        f"    one.{name} = {home}.data + start[{i}];\n" for i, (name, home) in enumerate(homes)
    ]
    return (
        "#pragma clang fp reassociate(on) contract(fast)\n"
        "    #define APART __attribute__((noinline))\n"
        "    typedef SCALAR lanes __attribute__((vector_size(LANES * sizeof(SCALAR)),\n"
        "                                        aligned(sizeof(SCALAR))));\n"
        "    typedef double wide __attribute__((vector_size(LANES * sizeof(double)),\n"
        "                                       aligned(sizeof(double))));\n"
        f"    struct Maps {{\n{members}{TOOLS}{GATHER}{CONCLUDE}    }};\n"
        "    const int* start = places.data;\n"
        f"    const int* given = counts.data + start[{len(NUMBERS)}];\n"
        f"    Maps one;\n{''.join(begin)}"
        f"    one.{call};\n"
    )


@cache
def make_reduced_maps(precision: str) -> SimpleNamespace:
    """The kernels ``gather`` and ``conclude``, each launched over one item."""
    types = real(precision)
    scalar, vec3, block = types.scalar, types.vec3, types.block
    kernel = types.kernel(SUBJECT)

    @types.native(_program("gather((SCALAR*)right.data)"))
    def gather_all(
        places: wp.array(dtype=int),
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
        right: wp.array2d(dtype=block),
    ): ...

    @kernel
    def gather(
        # in
        places: wp.array(dtype=int),
        # in and out
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
        # out
        right: wp.array2d(dtype=block),
    ):
        gather_all(places, counts, numbers, right)

    @types.native(
        _program(
            "conclude((const SCALAR*)x.data, (const SCALAR*)response.data, "
            "(const SCALAR*)maps.data, (const SCALAR*)momentum.data, lengths.data, reaches.data)"
        )
    )
    def conclude_all(
        places: wp.array(dtype=int),
        x: wp.array2d(dtype=block),
        response: wp.array(dtype=block),
        maps: wp.array2d(dtype=block),
        momentum: wp.array(dtype=vec3),
        lengths: wp.array(dtype=scalar),
        reaches: wp.array(dtype=scalar),
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ): ...

    @kernel
    def conclude(
        # in
        places: wp.array(dtype=int),
        x: wp.array2d(dtype=block),
        response: wp.array(dtype=block),
        maps: wp.array2d(dtype=block),
        momentum: wp.array(dtype=vec3),
        lengths: wp.array(dtype=scalar),
        reaches: wp.array(dtype=scalar),
        # in and out
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ):
        conclude_all(places, x, response, maps, momentum, lengths, reaches, counts, numbers)

    return SimpleNamespace(gather=gather, conclude=conclude)
