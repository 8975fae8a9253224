"""Closest rotations of matrices side by side in native code, for processors.

The closed form of ``polar_rotation`` is a chain of operations that wait for each other. Side by
side, an iteration for the polar factor (``lanes``) fills vector registers, to rounding with the
same result. Matrices whose rotation is hardly unique, or which mirror, are left to the closed form.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.lanes import GROUP, prelude
from warp_softbody.kernels.elastic.polar_rotation import make_rotation
from warp_softbody.kernels.precision import real

SUBJECT = "rotation_lanes"

# ``odd`` gets a bit for each matrix that stays as it is.
ROTATE = """
    int bits = 0;
    for (int begin = 0; begin < LANES; begin += WIDE) {
        const int first = LANES * group + begin, left = (int)matrices.shape[0] - first;
        const int count = left < WIDE ? left : WIDE;
        if (count <= 0) break;
        SCALAR* own = (SCALAR*)matrices.data + 9 * (size_t)first;
        lanes F[9], R[9];
        load_matrices(own, [&](int l) { return l < count ? l : count - 1; }, F);
        const choice apart = rotate(F, R);
        for (int i = 0; i < 9; ++i) R[i] = apart ? F[i] : R[i];
        store_matrices(own, R, count);
        for (int l = 0; l < count; ++l) bits |= (apart[l] ? 1 : 0) << (begin + l);
    }
    odd.data[group] = bits;
"""


def rotation_lanes_on(device: str, precision: str) -> SimpleNamespace | None:
    """The kernel of this module where a device is a processor; None elsewhere."""
    return make_rotation_lanes(precision) if wp.get_device(device).is_cpu else None


@cache
def make_rotation_lanes(precision: str) -> SimpleNamespace:
    """Kernel ``rotate``: in place, every matrix becomes the rotation closest to it.

    A thread turns a group of ``GROUP`` matrices.
    """
    types = real(precision)
    mat33, kernel = types.mat33, types.kernel(SUBJECT)
    closest_rotation = make_rotation(precision, SUBJECT).closest_rotation
    group_size = wp.constant(GROUP)

    @types.native(prelude(precision) + ROTATE)
    def rotate_group(group: int, matrices: wp.array(dtype=mat33), odd: wp.array(dtype=int)): ...

    @kernel
    def rotate(
        # in and out
        matrices: wp.array(dtype=mat33),
        # out
        odd: wp.array(dtype=int),
    ):
        g = wp.tid()
        rotate_group(g, matrices, odd)
        left = odd[g]
        t = group_size * g
        while left != 0:
            if (left & 1) != 0:
                matrices[t] = closest_rotation(matrices[t])
            left = left >> 1
            t += 1

    return SimpleNamespace(rotate=rotate)
