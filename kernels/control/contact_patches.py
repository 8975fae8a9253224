"""The patches of a step as native code, for processors: quadrature, gaps, frames and friction.

It does what ``contact_quadrature``, ``contact_frames`` and ``patches`` of the controllers do in
NumPy, in double precision and one thread, with no array made on the way; these are the reference.
"""

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import NamedTuple

import warp as wp

from warp_softbody.kernels.precision import real

SUBJECT = "contact_patches"

LIMITS = {"TINY": "2.2250738585072014e-308", "UPRIGHT_SHARE": "0.01"}
"""Constants of the native code; those of the NumPy form have their names."""

ANGLES = 8
"""Directions for which a patch keeps a factor on its friction."""


class PatchSizes(NamedTuple):
    """What the shapes of all arrays follow from, named as in the native code."""

    n: int
    """Nodes of all bodies."""
    own: int
    """Nodes of the character."""
    k: int
    """Nodes of the parts, one after the other."""
    p: int
    """Parts."""
    f: int
    """Faces."""
    shared: int
    """Faces around nodes, node after node."""
    carried: int
    """Entries of the rows that carry directions with the body; none without such friction."""
    flat: int
    """Whether the ground is a plane; else its gaps and normals are handed in."""


Shape = Callable[[PatchSizes], tuple[int, ...]]

NUMBERS: dict[str, Shape] = {
    # constant
    "plane": lambda a: (4,),
    "nearest": lambda a: (3, a.own),
    "carrier": lambda a: (a.carried,),
    "node_factors": lambda a: (a.k if a.carried else 0, ANGLES),
    "scalars": lambda a: (3,),
    # of the step
    "positions": lambda a: (a.n, 3),
    "velocities": lambda a: (a.n, 3),
    "impulses": lambda a: (a.n, 3),
    "gaps": lambda a: (a.k,),
    "normals": lambda a: (a.k, 3),
    # on the way
    "crosses": lambda a: (a.f, 4),
    "node_areas": lambda a: (a.k,),
    "borne": lambda a: (a.k,),
    "shares": lambda a: (a.k,),
    "every": lambda a: (a.n,),
    "lowest": lambda a: (a.p,),
    # of the patches
    "weights": lambda a: (a.p, a.n),
    "patch_gaps": lambda a: (a.p,),
    "areas": lambda a: (a.p,),
    "frames": lambda a: (a.p, 3, 3),
    "factors": lambda a: (a.p, ANGLES),
}
"""Arrays of double precision: ``plane`` is normal and offset, ``scalars`` are the reach (m), the
impulse at which a patch weighs half by what it bore, and the speed at which its sliding decides."""

COUNTS: dict[str, Shape] = {
    "settings": lambda a: (len(PatchSizes._fields),),
    "nodes": lambda a: (a.k,),
    "begins": lambda a: (a.p + 1,),
    "faces": lambda a: (a.f, 3),
    "face_begins": lambda a: (a.k + 1,),
    "faces_around": lambda a: (a.shared,),
    "carrier_begins": lambda a: (a.k + 1,),
    "carrier_nodes": lambda a: (a.carried,),
    "touching": lambda a: (a.n,),
    "patch_touches": lambda a: (a.p,),
}
"""Arrays of whole numbers; rows of sparse matrices begin where ``..._begins`` says."""

TOOLS = """
    static double max_of(double a, double b) { return a > b ? a : b; }
    static double min_of(double a, double b) { return a < b ? a : b; }
    static double dot(const double* a, const double* b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
    static double size_of(const double* a) { return __builtin_sqrt(dot(a, a)); }
    static void cross(const double* a, const double* b, double* to) {
        to[0] = a[1] * b[2] - a[2] * b[1];
        to[1] = a[2] * b[0] - a[0] * b[2];
        to[2] = a[0] * b[1] - a[1] * b[0];
    }
"""

QUADRATURE = """
    // Gaps, areas that face the ground, and normal impulses of all nodes of the parts.
    APART void measure() {
        for (int i = 0; i < f; ++i) {
            const double *a = positions + 3 * faces[3 * i], *b = positions + 3 * faces[3 * i + 1];
            const double* c = positions + 3 * faces[3 * i + 2];
            const double one[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
            const double other[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
            cross(one, other, crosses + 4 * i);
            crosses[4 * i + 3] = size_of(crosses + 4 * i);
        }
        for (int i = 0; i < n; ++i) every[i] = 0.0;
        for (int j = 0; j < k; ++j) {
            const double* place = positions + 3 * nodes[j];
            double* normal = normals + 3 * j;
            if (flat) {
                for (int a = 0; a < 3; ++a) normal[a] = plane[a];
                gaps[j] = dot(place, plane) - plane[3];
            }
            double around[4] = {};
            for (int e = face_begins[j]; e < face_begins[j + 1]; ++e)
                for (int a = 0; a < 4; ++a) around[a] += crosses[4 * faces_around[e] + a] / 6.0;
            node_areas[j] = max_of(-dot(around, normal), UPRIGHT_SHARE * around[3]);
            every[nodes[j]] += node_areas[j];
            borne[j] = max_of(dot(impulses + 3 * nodes[j], normal), 0.0);
        }
        // parts with nodes in common share what these bore
        for (int j = 0; p > 1 && j < k; ++j)
            borne[j] *= node_areas[j] / max_of(every[nodes[j]], TINY);
    }

    // Shares of the nodes, gaps of the patches, and their areas among all.
    APART void share_out() {
        const double reach = scalars[0], light = scalars[1];
        double least = 1.7e308, all = 0.0, pressed = 0.0;
        for (int i = 0; i < p; ++i) {
            lowest[i] = gaps[begins[i]];
            for (int j = begins[i]; j < begins[i + 1]; ++j) lowest[i] = min_of(lowest[i], gaps[j]);
            least = min_of(least, lowest[i]);
            double size = 0.0, sum = 0.0;
            for (int j = begins[i]; j < begins[i + 1]; ++j) {
                shares[j] = node_areas[j] * ::exp((lowest[i] - gaps[j]) / reach);
                size += shares[j];
                pressed = max_of(pressed, borne[j]);
            }
            // a part without any surface, as within the body
            for (int j = begins[i]; j < begins[i + 1]; ++j) {
                if (!(size > 0.0)) shares[j] = gaps[j] <= lowest[i];
                sum += shares[j];
            }
            for (int j = begins[i]; j < begins[i + 1]; ++j) shares[j] /= sum;
            areas[i] = size;
        }
        for (int i = 0; i < p; ++i) {
            areas[i] *= ::exp((least - lowest[i]) / reach);
            all += areas[i];
        }
        for (int i = 0; i < p; ++i) {
            areas[i] = all != 0.0 ? areas[i] / all : 1.0 / p;
            patch_gaps[i] = lowest[i];
            double impulse = 0.0, gap = 0.0, all_gaps = 0.0;
            for (int j = begins[i]; j < begins[i + 1]; ++j) {
                impulse += borne[j];
                all_gaps += gaps[j];
            }
            // what is no number stays none, though no comparison has seen it
            patch_gaps[i] += 0.0 * all_gaps;
            if (pressed == 0.0) continue;
            const double loaded = impulse / max_of(impulse + light, TINY);
            for (int j = begins[i]; j < begins[i + 1]; ++j) {
                const double bearing = borne[j] * (loaded / max_of(impulse, TINY));
                shares[j] = (1.0 - loaded) * shares[j] + bearing;
                gap += bearing * gaps[j];
            }
            patch_gaps[i] = (1.0 - loaded) * patch_gaps[i] + gap;
        }
        for (int i = 0; i < p; ++i) {
            patch_touches[i] = 0;
            for (int j = begins[i]; j < begins[i + 1]; ++j) {
                weights[(size_t)i * n + nodes[j]] = shares[j];
                patch_touches[i] |= touching[nodes[j]];
            }
        }
    }
"""

FRAMES = """
    // Rows normal, tangent 1 along x where possible, tangent 2.
    static void upright(double* frame) {
        const int axis = !(frame[0] < 0.9 && frame[0] > -0.9);
        for (int a = 0; a < 3; ++a) frame[3 + a] = (a == axis) - frame[axis] * frame[a];
        const double size = size_of(frame + 3);
        for (int a = 0; a < 3; ++a) frame[3 + a] /= size;
        cross(frame, frame + 3, frame + 6);
    }
    // A product of two complex numbers, into the first.
    static void multiply(double* a, double x, double y) {
        const double real = a[0] * x - a[1] * y;
        a[1] = a[0] * y + a[1] * x;
        a[0] = real;
    }

    // The frame turned along the motion, whose four ways are three axes and the sliding.
    static void along_motion(double* frame, const double* motions) {
        double ahead[2] = {}, fourth[2] = {};
        for (int i = 0; i < 4; ++i) {
            const double x = dot(motions + 3 * i, frame + 3), y = dot(motions + 3 * i, frame + 6);
            // forward as the body has it: x and, where that is upright, y a quarter back
            if (i == 0) ahead[0] = x, ahead[1] = y;
            if (i == 1) ahead[0] += y, ahead[1] -= x;
            double power[2] = {x * x - y * y, 2.0 * x * y};
            multiply(power, power[0], power[1]);
            fourth[0] += power[0];
            fourth[1] += power[1];
        }
        const double size = __builtin_sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1]);
        ahead[0] = size > 0.0 ? ahead[0] / size : 1.0;
        ahead[1] = size > 0.0 ? ahead[1] / size : 0.0;
        for (int i = 0; i < 4; ++i) multiply(fourth, ahead[0], -ahead[1]);
        const double angle = 0.25 * ::atan2(fourth[1], fourth[0]);
        multiply(ahead, ::cos(angle), ::sin(angle));
        for (int a = 0; a < 3; ++a) {
            const double first = frame[3 + a], second = frame[6 + a];
            frame[3 + a] = ahead[0] * first + ahead[1] * second;
            frame[6 + a] = ahead[0] * second - ahead[1] * first;
        }
    }

    APART void find_frames() {
        double motions[12] = {};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < own; ++j)
                for (int a = 0; a < 3; ++a)
                    motions[3 * i + a] += nearest[(size_t)i * own + j] * positions[3 * j + a];
        bool same = true;
        for (int j = 0; j < k; ++j)
            for (int a = 0; a < 3; ++a) same = same && normals[3 * j + a] == normals[a];
        for (int i = 0; i < p; ++i) {
            double *frame = frames + 9 * i, *slip = motions + 9;
            for (int a = 0; a < 3; ++a) {
                frame[a] = same ? normals[a] : 0.0;
                slip[a] = 0.0;
            }
            for (int j = begins[i]; j < begins[i + 1]; ++j)
                for (int a = 0; a < 3; ++a) {
                    slip[a] += shares[j] * velocities[3 * nodes[j] + a];
                    if (!same) frame[a] += shares[j] * normals[3 * j + a];
                }
            const double size = same ? 1.0 : size_of(frame);
            for (int a = 0; a < 3; ++a) {
                frame[a] /= size;
                slip[a] /= scalars[2];
            }
            upright(frame);
            along_motion(frame, motions);
        }
    }
"""

FRICTION = """
    // Factors of the patches by the direction of the force, which opposes the sliding.
    APART void find_factors() {
        const double turn = 6.283185307179586;
        for (int i = 0; i < p; ++i) {
            double* to = factors + ANGLES * i;
            for (int a = 0; a < ANGLES; ++a) to[a] = carried ? 0.0 : 1.0;
            for (int j = begins[i]; carried && j < begins[i + 1]; ++j) {
                double way[3] = {};
                for (int e = carrier_begins[j]; e < carrier_begins[j + 1]; ++e)
                    for (int a = 0; a < 3; ++a)
                        way[a] += carrier[e] * positions[3 * carrier_nodes[e] + a];
                const double* frame = frames + 9 * i;
                const double forward = ::atan2(dot(frame + 6, way), dot(frame + 3, way));
                for (int a = 0; a < ANGLES; ++a) {
                    const double angle = 0.5 * turn + turn * a / ANGLES - forward;
                    double place = (angle - turn * ::floor(angle / turn)) * ANGLES / turn;
                    if (!(place >= 0.0)) place = 0.0;
                    const int low = (int)place;
                    const double *given = node_factors + ANGLES * j, rest = place - low;
                    const double first = given[low % ANGLES], second = given[(low + 1) % ANGLES];
                    to[a] += shares[j] * (first + rest * (second - first));
                }
            }
        }
    }

    void run() {
        measure();
        share_out();
        find_frames();
        find_factors();
    }
"""


def _program() -> str:
    """The body of the native function."""
    members = "".join(f"    int {name};\n" for name in PatchSizes._fields)
    members += "".join(f"    double* {name};\n" for name in NUMBERS)
    members += "".join(f"    int* {name};\n" for name in COUNTS)
    homes = [(name, "numbers") for name in NUMBERS] + [(name, "counts") for name in COUNTS]
    begin = [f"    one.{name} = given[{i}];\n" for i, name in enumerate(PatchSizes._fields)]
    begin += [
        f"    one.{name} = {home}.data + start[{i}];\n" for i, (name, home) in enumerate(homes)
    ]
    constants = "".join(
        f"    constexpr double {name} = {value};\n" for name, value in LIMITS.items()
    )
    return (
        "#define APART __attribute__((noinline))\n"
        f"{constants}    constexpr int ANGLES = {ANGLES};\n"
        f"    struct Patches {{\n{members}{TOOLS}{QUADRATURE}{FRAMES}{FRICTION}    }};\n"
        "    const int* start = places.data;\n"
        f"    const int* given = counts.data + start[{len(NUMBERS)}];\n"
        f"    Patches one;\n{''.join(begin)}"
        "    one.run();\n"
    )


@cache
def make_contact_patches() -> SimpleNamespace:
    """The kernel ``find``, launched over one item."""
    types = real("float64")
    kernel = types.kernel(SUBJECT)

    @types.native(_program())
    def find_all(
        places: wp.array(dtype=int),
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ): ...

    @kernel
    def find(
        # in
        places: wp.array(dtype=int),
        # in and out
        counts: wp.array(dtype=int),
        numbers: wp.array(dtype=wp.float64),
    ):
        find_all(places, counts, numbers)

    return SimpleNamespace(find=find)
