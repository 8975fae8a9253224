"""The proper rotation closest to a 3 x 3 matrix, also where it is flat or inverted.

R maximises tr(R^T F); the maximum is lambda = s1 + s2 + s3, s3 signed as det F. It is the largest
root of ``l^4 - 2 n l^2 - 8 d l + n^2 - 4 c = 0`` with n = |F|^2, d = det F, c = |cof F|^2 (Horn
1987 gives this as the characteristic polynomial of the quaternion matrix), found by Newton's method
from above. As R = d lambda / d F (envelope theorem), differentiating the quartic gives R in closed
form: ``R = ((l^2 + n) F + 2 l cof F - 2 F F^T F) / (l^3 - n l - 2 d)``.
One Newton-Schulz step and one Newton step on the rotation group remove what rounding left. The
denominator is (s1 + s2)(s1 + s3)(s2 + s3); near its zeros, where R is hardly unique, the quaternion
matrix itself is raised to a high power instead.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warp_softbody.kernels.elastic.tet_geometry import make_tets
from warp_softbody.kernels.precision import real


@cache
def make_rotation(precision: str, subject: str) -> SimpleNamespace:
    """Function ``closest_rotation(F)`` for the kernels of a subject, and its limits.

    Newton's method ends at a step below ``stop``; below ``unsafe`` the denominator counts as zero.
    """
    types = real(precision)
    scalar, vec3, mat33, mat44 = types.scalar, types.vec3, types.mat33, types.mat44
    tiny = wp.constant(scalar(types.tiny))
    least_step, least_gap = 2e-7 if precision == "float32" else 1e-15, 2e-2
    stop = wp.constant(scalar(least_step))
    unsafe = wp.constant(scalar(least_gap))
    squarings = wp.constant(30 if precision == "float32" else 60)
    func = types.func(subject)
    cofactor = make_tets(precision, subject).cofactor

    @func
    def largest_root(determinant: scalar, cofactor_square: scalar):
        # with |F| = 1 the root lies in [1 / sqrt(3), sqrt(3)]; Newton from above is monotone
        root = scalar(1.7320508075688772)
        constant = scalar(1.0) - scalar(4.0) * cofactor_square
        iteration = int(0)
        while iteration < 16:
            square = root * root
            value = (square - scalar(2.0)) * square - scalar(8.0) * determinant * root + constant
            slope = scalar(4.0) * root * (square - scalar(1.0)) - scalar(8.0) * determinant
            iteration += 1
            if slope < scalar(4.0) * unsafe:
                # slope / 4 is R's denominator and shrinks with the root: no need of the root
                iteration = 16
            else:
                step = value / slope
                root = root - step
                if wp.abs(step) < stop:
                    iteration = 16
        return root

    @func
    def rotation_by_powers(F: mat33):
        # tr(R(q)^T F) = q^T K q (Horn 1987): q is the eigenvector of K's largest eigenvalue. K lies
        # within +-sqrt(3) for |F| = 1; squared over and over, K + 2 becomes the projector onto it,
        # also where the eigenvalue is multiple and any q of its space is as good
        a, b, c = F[2, 1] - F[1, 2], F[0, 2] - F[2, 0], F[1, 0] - F[0, 1]
        d, e, f = F[0, 1] + F[1, 0], F[0, 2] + F[2, 0], F[1, 2] + F[2, 1]
        x, y, z = F[0, 0], F[1, 1], F[2, 2]
        P = mat44(x + y + z, a, b, c, a, x - y - z, d, e, b, d, y - x - z, f, c, e, f, z - x - y)
        P = P + scalar(2.0) * wp.identity(n=4, dtype=scalar)
        squaring = int(0)
        while squaring < squarings:
            P = P * P
            P = P / wp.trace(P)
            squaring += 1
        best = int(0)
        for k in range(1, 4):
            if P[k, k] > P[best, best]:
                best = k
        q = wp.normalize(P[best])
        w = q[0]
        v = vec3(q[1], q[2], q[3])
        K = wp.skew(v)
        return wp.identity(n=3, dtype=scalar) + scalar(2.0) * (w * K + K * K)

    @func
    def newton_on_group(R: mat33, F: mat33):
        # gradient and Hessian of tr(exp(w)^T R^T F): (tr S - S) w = axial(S), S = R^T F
        S = wp.transpose(R) * F
        axial = vec3(S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1])
        half = scalar(0.5)
        h01 = -half * (S[0, 1] + S[1, 0])
        h02 = -half * (S[0, 2] + S[2, 0])
        h12 = -half * (S[1, 2] + S[2, 1])
        r0 = vec3(S[1, 1] + S[2, 2], h01, h02)
        r1 = vec3(h01, S[0, 0] + S[2, 2], h12)
        r2 = vec3(h02, h12, S[0, 0] + S[1, 1])
        c0 = wp.cross(r1, r2)
        volume = wp.dot(r0, c0)
        turn = vec3()
        if wp.abs(volume) > tiny:
            w = (axial[0] * c0 + axial[1] * wp.cross(r2, r0) + axial[2] * wp.cross(r0, r1)) / volume
            if wp.dot(w, w) < scalar(0.01):
                turn = w
        # Cayley map: an exact rotation, and the exponential to third order
        k = half * turn
        q = scalar(1.0) / (scalar(1.0) + wp.dot(k, k))
        K = wp.skew(k)
        return R + (scalar(2.0) * q) * (R * (K + K * K))

    @func
    def closest_rotation(F: mat33):
        norm = wp.sqrt(wp.ddot(F, F))
        if norm <= tiny:
            return wp.identity(n=3, dtype=scalar)
        A = F / norm
        cof = cofactor(A)
        d = wp.determinant(A)
        root = largest_root(d, wp.ddot(cof, cof))
        gap = root * (root * root - scalar(1.0)) - scalar(2.0) * d
        if gap < unsafe:
            return newton_on_group(rotation_by_powers(A), A)
        R = ((root * root + scalar(1.0)) * A + scalar(2.0) * root * cof) / gap
        R = R - (scalar(2.0) / gap) * (A * (wp.transpose(A) * A))
        R = scalar(0.5) * R * (scalar(3.0) * wp.identity(n=3, dtype=scalar) - wp.transpose(R) * R)
        return newton_on_group(R, A)

    return SimpleNamespace(closest_rotation=closest_rotation, stop=least_step, unsafe=least_gap)
