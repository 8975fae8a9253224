"""Native code that kernels over many matrices side by side share: types, loads, stores, rotations.

``lanes`` is a vector of as many numbers as a register holds, one of each item; ``WIDE`` of them,
a part of a group. ``gathered`` and ``scattered`` transpose what stands together for an item.

``rotate`` finds the closest rotations by Newton's iteration for the polar factor, A becoming the
mean of itself and its inverse transpose (Higham 1986), scaled first. That is some 40 operations an
iteration, of which a tet at work needs three or four. Where the matrix is flat, inverted or NaN the
lane is left to the closed form of ``polar_rotation``: ``odd`` is set, and R is of no use.
"""

from warp_softbody.kernels.precision import BLOCK

GROUP = BLOCK
"""Items of one thread."""

LEAST_DETERMINANT = 0.05
"""Of a matrix as large as a rotation, where the iteration serves."""

MOST_ITERATIONS = 12
"""More than it takes there: it begins within a factor of 14 and then halves the distance."""

EXCESS = {"float32": 5e-4, "float64": 8e-9}
"""|A|^2 - 3 from which one more iteration ends at a rounding, by precision."""

PRELUDE = """
#pragma clang fp contract(fast)
#if defined(__AVX512F__)
    enum { WIDE = 64 / sizeof(SCALAR) };
#else
    enum { WIDE = 32 / sizeof(SCALAR) };
#endif
    typedef SCALAR lanes __attribute__((vector_size(WIDE * sizeof(SCALAR))));
    typedef decltype(lanes{} < lanes{}) choice;
    typedef SCALAR quad __attribute__((vector_size(4 * sizeof(SCALAR)), aligned(sizeof(SCALAR))));
    // four numbers of every item l, which begin at from(l), to four vectors
    const auto gathered = [](auto from, lanes* to) {
        for (int l = 0; l < WIDE; l += 4) {
            const quad a = from(l), b = from(l + 1), c = from(l + 2), d = from(l + 3);
            const quad ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
            const quad cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
            const quad AB = __builtin_shufflevector(a, b, 2, 6, 3, 7);
            const quad CD = __builtin_shufflevector(c, d, 2, 6, 3, 7);
            const quad out[4] = {__builtin_shufflevector(ab, cd, 0, 1, 4, 5),
                                 __builtin_shufflevector(ab, cd, 2, 3, 6, 7),
                                 __builtin_shufflevector(AB, CD, 0, 1, 4, 5),
                                 __builtin_shufflevector(AB, CD, 2, 3, 6, 7)};
            for (int k = 0; k < 4; ++k)
                for (int j = 0; j < 4; ++j) to[k][l + j] = out[k][j];
        }
    };
    // and back, of the first ``count`` items: put(l, their four numbers)
    const auto scattered = [](lanes p, lanes q, lanes r, lanes s, int count, auto put) {
        for (int l = 0; l < WIDE; l += 4) {
            quad a, b, c, d;
            for (int j = 0; j < 4; ++j) {
                a[j] = p[l + j];
                b[j] = q[l + j];
                c[j] = r[l + j];
                d[j] = s[l + j];
            }
            const quad ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
            const quad cd = __builtin_shufflevector(c, d, 0, 4, 1, 5);
            const quad AB = __builtin_shufflevector(a, b, 2, 6, 3, 7);
            const quad CD = __builtin_shufflevector(c, d, 2, 6, 3, 7);
            if (l < count) put(l, __builtin_shufflevector(ab, cd, 0, 1, 4, 5));
            if (l + 1 < count) put(l + 1, __builtin_shufflevector(ab, cd, 2, 3, 6, 7));
            if (l + 2 < count) put(l + 2, __builtin_shufflevector(AB, CD, 0, 1, 4, 5));
            if (l + 3 < count) put(l + 3, __builtin_shufflevector(AB, CD, 2, 3, 6, 7));
        }
    };
    const lanes zero = {}, one = zero + (SCALAR)1.0, half = zero + (SCALAR)0.5;
    // matrices of items at(l), 9 numbers each by rows
    const auto load_matrices = [&](const SCALAR* from, auto at, lanes* to) {
        gathered([&](int l) { return *(const quad*)(from + 9 * (size_t)at(l)); }, to);
        gathered([&](int l) { return *(const quad*)(from + 9 * (size_t)at(l) + 4); }, to + 4);
        for (int l = 0; l < WIDE; ++l) to[8][l] = from[9 * (size_t)at(l) + 8];
    };
    const auto store_matrices = [&](SCALAR* to, const lanes* from, int count) {
        scattered(from[0], from[1], from[2], from[3], count,
                  [&](int l, quad v) { *(quad*)(to + 9 * l) = v; });
        scattered(from[4], from[5], from[6], from[7], count,
                  [&](int l, quad v) { *(quad*)(to + 9 * l + 4) = v; });
        for (int l = 0; l < count; ++l) to[9 * l + 8] = from[8][l];
    };
    const auto cofactors = [](const lanes* a, lanes* c) {
        c[0] = a[4] * a[8] - a[5] * a[7];
        c[1] = a[5] * a[6] - a[3] * a[8];
        c[2] = a[3] * a[7] - a[4] * a[6];
        c[3] = a[2] * a[7] - a[1] * a[8];
        c[4] = a[0] * a[8] - a[2] * a[6];
        c[5] = a[1] * a[6] - a[0] * a[7];
        c[6] = a[1] * a[5] - a[2] * a[4];
        c[7] = a[2] * a[3] - a[0] * a[5];
        c[8] = a[0] * a[4] - a[1] * a[3];
    };
    const auto square_of = [](const lanes* a) {
        return (a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
            + (a[3] * a[3] + a[4] * a[4] + a[5] * a[5])
            + (a[6] * a[6] + a[7] * a[7] + a[8] * a[8]);
    };
    const auto rotate = [&](const lanes* F, lanes* R) {
        lanes C[9];
        cofactors(F, C);
        lanes determinant = F[0] * C[0] + F[1] * C[1] + F[2] * C[2];
        lanes size = __builtin_elementwise_sqrt((SCALAR)3.0 / square_of(F));
        const choice odd = ~(determinant * size * size * size > (SCALAR)LEAST);
        size = odd ? one : size;
        determinant = odd ? one : determinant;
        const lanes first = half * size, share = half / (size * determinant);
        for (int i = 0; i < 9; ++i) {
            const lanes unit = i % 4 == 0 ? one : zero;
            R[i] = odd ? unit : first * F[i] + share * C[i];
        }
        // a lane stops by itself, so that its bits do not depend on those beside it
        choice active = R[0] == R[0];
        for (int k = 0; k < MOST && __builtin_reduce_or(active); ++k) {
            const choice more = square_of(R) - (SCALAR)3.0 > (SCALAR)ENOUGH;
            cofactors(R, C);
            const lanes part = half / (R[0] * C[0] + R[1] * C[1] + R[2] * C[2]);
            for (int i = 0; i < 9; ++i) R[i] = active ? half * R[i] + part * C[i] : R[i];
            active = active & more;
        }
        return odd;
    };
"""


def prelude(precision: str) -> str:
    """The shared part of a snippet."""
    text = PRELUDE.replace("LEAST", repr(LEAST_DETERMINANT)).replace("MOST", str(MOST_ITERATIONS))
    return text.replace("ENOUGH", repr(EXCESS[precision]))
