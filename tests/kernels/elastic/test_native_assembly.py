"""Native code of smoothed elements and implicit muscles against the plain kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.bodies import box, crumpled, epsilon, muscular_bar, numbers, rig
from warp_softbody.body.material import Material
from warp_softbody.characters import letter_i
from warp_softbody.engine.options import Precision


def assembled(character: Any, amount: float = 0.08, **options: Any) -> list[np.ndarray[Any, Any]]:
    """Matrix, impulses and node rotations of a crumpled, moving body."""
    body = rig(character, time_step=0.01, **options)
    points = np.asarray(body.model.body.mesh.points)
    velocities = np.random.default_rng(2).standard_normal(points.shape)
    body.place(crumpled(body.model.body.mesh, amount=amount), velocities)
    body.stepper.assemble(body.state)
    own = body.stepper.assembly
    found = [own.values, own.impulses, own.node_rotations]
    if own.muscles is not None:
        found += [own.muscles.lengths, own.muscles.reaches, own.muscles.reciprocals]
    return [numbers(array) for array in found]


def same(native: list[Any], plain: list[Any], precision: Precision) -> None:
    for found, expected in zip(native, plain, strict=True):
        bound = 256 * epsilon(precision) * np.abs(expected).max()
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=bound)


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("tangent", ["warped", "conserving"])
@pytest.mark.parametrize("volume", ["exact", "linear"])
def test_smoothed_elements(volume: Any, tangent: Any, precision: Precision) -> None:
    if volume == "linear" and tangent == "conserving":
        pytest.skip("no such tangent")
    options: dict[str, Any] = {"elements": "smoothed", "tangent": tangent, "precision": precision}
    material = Material(volume=volume)
    mesh = box((3, 3, 3), jitter=0.2)
    found = [
        assembled(mesh, material=material, native_code=native, **options)
        for native in (True, False)
    ]
    same(found[0], found[1], precision)


@pytest.mark.parametrize("elements", ["linear", "smoothed"])
@pytest.mark.parametrize("amount", [0.3, 0.8])
def test_the_conserving_tangent_of_inverted_tets(amount: float, elements: Any) -> None:
    """Where two singular values cancel the rotation's derivative fades out, in both alike."""
    options: dict[str, Any] = {"elements": elements, "tangent": "conserving", "amount": amount}
    options |= {"precision": "float64", "material": Material(volume="exact")}
    mesh = box((3, 3, 3), jitter=0.2)
    found = [assembled(mesh, native_code=native, **options) for native in (True, False)]
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=0.0, atol=1e-9 * found[1][0].max())


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("many", [False, True])
def test_implicit_muscles(many: bool, precision: Precision, threads: int) -> None:
    """Of a bar whose tets feel a few segments, and of a letter's, which feel up to dozens."""
    options: dict[str, Any] = {"muscles": "implicit", "precision": precision, "threads": threads}
    body = letter_i() if many else muscular_bar(helix=True)
    found = [assembled(body, native_code=native, **options) for native in (True, False)]
    same(found[0], found[1], precision)
