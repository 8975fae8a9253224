"""The closest proper rotation: proper, orthonormal and optimal whatever the matrix."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.support.bodies import epsilon
from tests.verification.reference import polar_rotations
from warp_softbody.arrays import FloatArray
from warp_softbody.engine.options import Precision
from warp_softbody.kernels.elastic.corotated import make_elasticity
from warp_softbody.kernels.elastic.lanes import GROUP
from warp_softbody.kernels.elastic.rotation_lanes import make_rotation_lanes
from warp_softbody.kernels.precision import real

PRECISIONS: tuple[Precision, ...] = ("float32", "float64")


def random(count: int, seed: int = 0) -> FloatArray:
    return np.random.default_rng(seed).standard_normal((count, 3, 3))


def orthogonal(count: int, seed: int) -> FloatArray:
    return np.linalg.qr(random(count, seed))[0]


def with_singular_values(values: FloatArray, seed: int = 1) -> FloatArray:
    """U diag(values) V^T with U, V random orthogonal matrices of either sign."""
    U, V = orthogonal(len(values), seed), orthogonal(len(values), seed + 100)
    return (U * values[:, None, :]) @ V


def kernel_rotations(F: FloatArray, precision: Precision) -> FloatArray:
    """Rotations of tets whose rest edges are the axes and whose edges are the columns of F."""
    types, kernels, count = real(precision), make_elasticity(precision), len(F)
    positions = np.zeros((count, 4, 3))
    positions[:, 1:] = F.transpose(0, 2, 1)
    tets = np.arange(4 * count).reshape(-1, 4)
    # rotations, gradients and forces by corner with the area rows between them
    sizes = ((count, types.mat33), (4 * count, types.vec3)) * 2
    out: list[Any] = [wp.zeros(size, dtype=dtype, device="cpu") for size, dtype in sizes]
    wp.launch(
        kernels.deform_tets,
        dim=count,
        inputs=[
            wp.array(tets, dtype=wp.vec4i, device="cpu"),
            wp.array(np.tile(np.eye(3), (count, 1, 1)), dtype=types.mat33, device="cpu"),
            wp.array(np.ones(count), dtype=types.scalar, device="cpu"),
            wp.array([1.0, 1.0], dtype=types.scalar, device="cpu"),
            0,  # no muscles
            wp.array(positions.reshape(-1, 3), dtype=types.vec3, device="cpu"),
        ],
        outputs=out,
        device="cpu",
    )
    return np.asarray(out[0].numpy(), dtype=np.float64)


def rotations_side_by_side(F: FloatArray, precision: Precision) -> FloatArray:
    """The same by the native code of processors, sixteen at a time."""
    matrices: Any = wp.array(F, dtype=real(precision).mat33, device="cpu")
    groups = -(-len(F) // GROUP)
    odd = wp.zeros(groups, dtype=int, device="cpu")
    rotate = make_rotation_lanes(precision).rotate
    wp.launch(rotate, dim=groups, inputs=[matrices], outputs=[odd], device="cpu")
    return np.asarray(matrices.numpy(), dtype=np.float64)


def hard_cases() -> dict[str, FloatArray]:
    rng = np.random.default_rng(7)
    some = rng.uniform(0.2, 3.0, (300, 3))
    small = 10.0 ** rng.uniform(-9.0, -1.0, 300)
    one, zero = np.ones(300), np.zeros(300)
    stretch = np.sort(some, axis=1)[:, ::-1]
    flat = np.stack([stretch[:, 0], stretch[:, 1], zero], axis=1)
    nearly_flat = np.stack([stretch[:, 0], stretch[:, 1], small], axis=1)
    line = np.stack([one, zero, zero], axis=1)
    nearly_line = np.stack([one, small, small * rng.uniform(0.0, 1.0, 300)], axis=1)
    equal_pair = np.stack([one, small + 0.3, 0.3 * one], axis=1)
    flipped = with_singular_values(stretch)
    flipped[np.linalg.det(flipped) > 0.0] *= -1.0
    axes = np.array([np.diag(d) for d in np.ndindex(3, 3, 3)], dtype=float) - np.eye(3)
    return {
        "random": random(2000),
        "stretched": with_singular_values(stretch),
        "mirrored": flipped,
        "mirrored by equal stretches": -orthogonal(300, 5)
        * np.sign(np.linalg.det(orthogonal(300, 5)))[:, None, None],
        "flat": with_singular_values(flat),
        "nearly flat": with_singular_values(nearly_flat),
        "line": with_singular_values(line),
        "nearly a line": with_singular_values(nearly_line),
        "two nearly equal stretches, mirrored or not": with_singular_values(equal_pair),
        "nearly a rotation": orthogonal(300, 6) + small[:, None, None] * random(300, 8),
        "axis-aligned, zeros and reflections": axes,
        "zero": np.zeros((3, 3, 3)),
    }


CASES = hard_cases()
SCALES: dict[Precision, tuple[float, ...]] = {
    "float32": (1e-14, 1.0, 1e14),
    "float64": (1e-90, 1.0, 1e90),
}


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("name", CASES)
def test_rotation_is_proper_and_optimal(name: str, precision: Precision) -> None:
    """R^T R = I and tr(R^T F) as large as it can be.

    To rounding: a Jacobi decomposition multiplies some twelve rotations, a few eps each.
    """
    eps = epsilon(precision)
    for scale in SCALES[precision]:
        # what the kernel sees is the matrix rounded to its precision
        F = (scale * CASES[name]).astype(precision).astype(np.float64)
        R = kernel_rotations(F, precision)
        assert np.isfinite(R).all()
        identity = np.broadcast_to(np.eye(3), R.shape)
        np.testing.assert_allclose(R.transpose(0, 2, 1) @ R, identity, atol=48 * eps)
        np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=72 * eps)
        s = np.linalg.svd(F / scale, compute_uv=False)
        signs = np.where(np.linalg.det(F / scale) < 0.0, -1.0, 1.0)
        best = s[:, 0] + s[:, 1] + signs * s[:, 2]
        reached = np.einsum("mij,mij->m", R, F / scale)
        assert (reached >= best - 24 * eps * s.sum(axis=1)).all()


@pytest.mark.parametrize("precision", PRECISIONS)
def test_rotation_equals_the_singular_value_decomposition(precision: Precision) -> None:
    """Where R is unique its error is the rounding of F over the smallest sum of two stretches."""
    for name in ("random", "mirrored", "nearly flat", "nearly a rotation"):
        F = CASES[name].astype(precision).astype(np.float64)
        R = kernel_rotations(F, precision)
        s = np.linalg.svd(F, compute_uv=False)
        signs = np.where(np.linalg.det(F) < 0.0, -1.0, 1.0)
        gap = s[:, 1] + signs * s[:, 2]
        error = np.abs(R - polar_rotations(F)).max(axis=(1, 2))
        # in double precision the reference's own error is the larger part
        bound = 64 * epsilon(precision) * (1.0 + s[:, 0] / gap)
        clear = gap > 1e-3 * s[:, 0]
        assert clear.sum() > 0.8 * len(F)
        assert (error[clear] <= bound[clear]).all(), name


@pytest.mark.parametrize("precision", PRECISIONS)
def test_rotation_of_zero_is_the_identity(precision: Precision) -> None:
    np.testing.assert_array_equal(kernel_rotations(np.zeros((1, 3, 3)), precision)[0], np.eye(3))


@pytest.mark.parametrize("precision", PRECISIONS)
def test_rotation_of_a_rotation_is_itself(precision: Precision) -> None:
    R = orthogonal(500, 9)
    R *= np.sign(np.linalg.det(R))[:, None, None]
    np.testing.assert_allclose(kernel_rotations(R, precision), R, atol=8 * epsilon(precision))


@pytest.mark.parametrize("precision", PRECISIONS)
@pytest.mark.parametrize("kind", hard_cases())
def test_native_code_of_processors_finds_the_plain_kernel_s_rotations(
    kind: str, precision: Precision
) -> None:
    """To a few roundings, and to the last bit where compilers fuse no operations of their own."""
    F = np.concatenate([hard_cases()[kind], 1e-3 * random(5), np.zeros((2, 3, 3))])
    found, expected = rotations_side_by_side(F, precision), kernel_rotations(F, precision)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=16 * epsilon(precision))
