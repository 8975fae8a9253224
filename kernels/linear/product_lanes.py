"""Products of the matrix with a vector in native code, for processors.

They do what ``residual`` and ``product`` of ``pcg`` do, to rounding, with a row of a block to a
vector register. ``product`` goes through the blocks before the diagonal alone and adds the
transpose of each to the other row, which halves what is read. Blocks before the diagonal are read
with the number behind each row, blocks after it with the number before, so that nothing is read
beyond an array's ends.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.linear.codes import VelocityConstraint
from warp_softbody.kernels.linear.structs import make_linear_structs
from warp_softbody.kernels.precision import real

SUBJECT = "conjugate_gradients_lanes"

ROWS_AHEAD = 12
"""Rows whose blocks are fetched ahead: processors foresee no gaps."""

# ``stiffness``: a row of K times what ``low`` and ``high`` find across the edge to each neighbour.
COMMON = """
#pragma clang fp contract(fast)
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    typedef double wide __attribute__((vector_size(4 * sizeof(double))));
    const SCALAR *A = (const SCALAR*)values.data, *slip = (const SCALAR*)slip_stiffness.data;
    const SCALAR* axes = (const SCALAR*)constraint_axes.data;
    const int *starts = row_start.data, *columns = column.data;
    const auto at = [](const SCALAR* x) { return *(const quad*)x; };
    const auto node = [](const SCALAR* x, int i) {
        return quad{x[3 * i], x[3 * i + 1], x[3 * i + 2], 0};
    };
    const auto behind = [](quad v) { return __builtin_shufflevector(v, v, 3, 0, 1, 2); };
    // of three rows, each in the numbers of a register
    const auto sums_of = [](quad y0, quad y1, quad y2) {
        const quad first = __builtin_shufflevector(y0, y1, 0, 4, 1, 5);
        const quad last = __builtin_shufflevector(y0, y1, 2, 6, 3, 7);
        const quad sums = __builtin_shufflevector(first, y2, 0, 1, 4, 3)
            + __builtin_shufflevector(first, y2, 2, 3, 5, 3)
            + __builtin_shufflevector(last, y2, 0, 1, 6, 3);
        return quad{sums[0], sums[1], sums[2], 0};
    };
    const auto stiffness = [&](int i, auto low, auto high) {
        quad y0 = {}, y1 = {}, y2 = {}, z0 = {}, z1 = {}, z2 = {};
        const int diagonal = diagonal_slot.data[i], end = starts[i + 1];
        for (int k = starts[i]; k < diagonal; ++k) {
            const SCALAR* a = A + 9 * (size_t)k;
            const quad p = low(3 * columns[k]);
            y0 += at(a) * p;
            y1 += at(a + 3) * p;
            y2 += at(a + 6) * p;
        }
        for (int k = diagonal + 1; k < end; ++k) {
            const SCALAR* a = A + 9 * (size_t)k - 1;
            const quad p = high(3 * columns[k] - 1);
            z0 += at(a) * p;
            z1 += at(a + 3) * p;
            z2 += at(a + 6) * p;
        }
        const auto ahead = [](quad v) { return __builtin_shufflevector(v, v, 1, 2, 3, 0); };
        return sums_of(y0 + ahead(z0), y1 + ahead(z1), y2 + ahead(z2));
    };
    const auto slipped = [&](int i, quad v) {
        const SCALAR* g = slip + 9 * (size_t)i;
        return sums_of(at(g) * v, at(g + 3) * v, behind(behind(behind(at(g + 5)))) * v);
    };
    const auto dot = [](quad a, quad b) {
        const wide product =
            __builtin_convertvector(a, wide) * __builtin_convertvector(b, wide);
        return product[0] + product[1] + product[2];
    };
    const auto project = [&](int i, quad v) {
        const int kind = constraint_kinds.data[i];
        if (kind == NONE) return v;
        if (kind == FIXED) return quad{};
        const quad axis = node(axes, i), product = axis * v;
        const quad along = axis * (product[0] + product[1] + product[2]);
        return kind == PLANE ? v - along : along;
    };
    const auto put = [](SCALAR* x, int i, quad v) {
        for (int a = 0; a < 3; ++a) x[3 * i + a] = v[a];
    };
"""

PRODUCT = """
    const SCALAR* x = (const SCALAR*)p.data;
    quad* sums = (quad*)work.data;
    const int count = (int)p.shape[0];
    for (int i = 0; i < count; ++i) {
        const int ahead = i + AHEAD < count ? i + AHEAD : count - 1;
        const char* line = (const char*)(A + 9 * (size_t)starts[ahead]);
        const char* end = (const char*)(A + 9 * (size_t)diagonal_slot.data[ahead]);
        for (; line < end; line += 64) __builtin_prefetch(line);
        const quad here = node(x, i);
        quad y0 = {}, y1 = {}, y2 = {};
        const int diagonal = diagonal_slot.data[i];
        for (int k = starts[i]; k < diagonal; ++k) {
            const SCALAR* a = A + 9 * (size_t)k;
            const quad aside = at(x + 3 * columns[k]) - here;
            y0 += at(a) * aside;
            y1 += at(a + 3) * aside;
            y2 += at(a + 6) * aside;
            sums[columns[k]] -= at(a) * aside[0] + at(a + 3) * aside[1] + at(a + 6) * aside[2];
        }
        sums[i] = sums_of(y0, y1, y2);
    }
    for (int c = 0; chunk * c < count; ++c) {
        const int last = chunk * (c + 1) < count ? chunk * (c + 1) : count;
        double stiff_sum = 0, inertia_sum = 0;
        for (int i = chunk * c; i < last; ++i) {
            const quad here = node(x, i), own = damped_masses.data[i] * here;
            quad stiff = sums[i] + slipped(i, here);
            stiff[3] = 0;
            put((SCALAR*)q.data, i, project(i, own + stiff));
            stiff_sum += dot(here, stiff);
            inertia_sum += dot(here, own);
        }
        partial.data[c] = stiff_sum;
        mass_partial.data[c] = inertia_sum;
    }
""".replace("AHEAD", str(ROWS_AHEAD))

RESIDUAL = """
    const SCALAR *x = (const SCALAR*)before.data, *d = (const SCALAR*)change.data;
    double square = 0, moved_square = 0;
    wide whole = {};
    for (int i = first; i < last; ++i) {
        const quad here = node(x, i), more = node(d, i);
        const quad aside = behind(here), more_aside = behind(more);
        const SCALAR mass = masses.data[i], damped = damped_masses.data[i];
        const quad inertia = damped * more + (damped - mass) * here;
        const quad stiff = stiffness(
            i, [&](int j) { return (at(x + j) - here) + (at(d + j) - more); },
            [&](int j) { return (at(x + j) - aside) + (at(d + j) - more_aside); });
        quad value = node((const SCALAR*)right_side.data, i) - (inertia + stiff);
        value = project(i, value - slipped(i, here + more));
        put((SCALAR*)r.data, i, value);
        const quad step = mass * (more - node((const SCALAR*)start.data, i));
        square += dot(value, value);
        moved_square += dot(step, step);
        whole += __builtin_convertvector(value, wide);
    }
    squares.data[chunk] = square;
    moved.data[chunk] = moved_square;
    for (int a = 0; a < 3; ++a) ((double*)net.data)[3 * chunk + a] = follows ? whole[a] : 0.0;
"""


def product_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernels of this module where a device is a processor; None elsewhere."""
    return make_product_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_product_lanes(precision: str) -> SimpleNamespace:
    """Kernels ``residual`` and ``product``; one thread launches ``product``, with (n,) of work."""
    types = real(precision)
    scalar, vec3, vec4, mat33 = types.scalar, types.vec3, types.vec4, types.mat33
    kernel = types.kernel(SUBJECT)
    structs = make_linear_structs(precision)
    MatrixRows, ResidualSums = structs.MatrixRows, structs.ResidualSums
    NodeConstraints = structs.NodeConstraints
    common = COMMON
    for kind in VelocityConstraint:
        common = common.replace(kind.name, str(int(kind)))

    @types.native(common + PRODUCT)
    def rows_of_product(
        chunk: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        damped_masses: wp.array(dtype=scalar),
        values: wp.array(dtype=mat33),
        constraint_kinds: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        p: wp.array(dtype=vec3),
        q: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
        mass_partial: wp.array(dtype=wp.float64),
        work: wp.array(dtype=vec4),
    ): ...

    @types.native(common + RESIDUAL)
    def rows_of_residual(
        chunk: int,
        first: int,
        last: int,
        follows: int,
        row_start: wp.array(dtype=int),
        column: wp.array(dtype=int),
        diagonal_slot: wp.array(dtype=int),
        masses: wp.array(dtype=scalar),
        damped_masses: wp.array(dtype=scalar),
        values: wp.array(dtype=mat33),
        constraint_kinds: wp.array(dtype=int),
        constraint_axes: wp.array(dtype=vec3),
        slip_stiffness: wp.array(dtype=mat33),
        right_side: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        start: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        r: wp.array(dtype=vec3),
        squares: wp.array(dtype=wp.float64),
        moved: wp.array(dtype=wp.float64),
        net: wp.array(dtype=wp.vec3d),
    ): ...

    @kernel
    def residual(
        # model
        chunk: int,
        follows: int,
        rows: MatrixRows,
        # in
        values: wp.array(dtype=mat33),
        constraints: NodeConstraints,
        slip_stiffness: wp.array(dtype=mat33),
        right_side: wp.array(dtype=vec3),
        before: wp.array(dtype=vec3),
        start: wp.array(dtype=vec3),
        change: wp.array(dtype=vec3),
        # out
        r: wp.array(dtype=vec3),
        sums: ResidualSums,
    ):
        c = wp.tid()
        # fmt: off
        rows_of_residual(
            c, c * chunk, wp.min((c + 1) * chunk, change.shape[0]), follows, rows.row_start,
            rows.column, rows.diagonal_slot, rows.masses, rows.damped_masses, values,
            constraints.kinds, constraints.axes, slip_stiffness, right_side, before, start,
            change, r, sums.squares, sums.moved, sums.net,
        )
        # fmt: on

    @kernel
    def product(
        # model
        chunk: int,
        rows: MatrixRows,
        # in
        values: wp.array(dtype=mat33),
        constraints: NodeConstraints,
        slip_stiffness: wp.array(dtype=mat33),
        p: wp.array(dtype=vec3),
        # out
        q: wp.array(dtype=vec3),
        partial: wp.array(dtype=wp.float64),
        mass_partial: wp.array(dtype=wp.float64),
        work: wp.array(dtype=vec4),
    ):
        # fmt: off
        rows_of_product(
            chunk, rows.row_start, rows.column, rows.diagonal_slot, rows.damped_masses, values,
            constraints.kinds, constraints.axes, slip_stiffness, p, q, partial, mass_partial, work,
        )
        # fmt: on

    return SimpleNamespace(residual=residual, product=product)
