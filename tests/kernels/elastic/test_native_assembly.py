"""Native code of elements and implicit muscles against the plain kernels."""

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
@pytest.mark.parametrize("amount", [0.08, 0.8])
@pytest.mark.parametrize("volume", ["exact", "linear"])
def test_linear_elements(volume: Any, amount: float, precision: Precision) -> None:
    """Also of a body of which every third tet is inverted; the letter has muscles of both kinds."""
    options: dict[str, Any] = {"elements": "linear", "tangent": "warped", "precision": precision}
    options |= {"material": Material(volume=volume), "amount": amount}
    mesh = box((3, 3, 3), jitter=0.2)
    found = [assembled(mesh, native_code=native, **options) for native in (True, False)]
    same(found[0], found[1], precision)


def test_area_rows_of_explicit_muscles() -> None:
    rows = []
    for native in (True, False):
        body = rig(muscular_bar(), muscles="explicit", native_code=native, time_step=0.01)
        body.place(crumpled(body.model.body.mesh, amount=0.08))
        body.stepper.assemble(body.state)
        rows.append(numbers(body.stepper.assembly.area_rows))
    same(rows[:1], rows[1:], "float32")


@pytest.mark.parametrize("volume", ["exact", "linear"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_flat_and_lost_tets_leave_those_beside_them_alone(
    precision: Precision, volume: Any
) -> None:
    """A node that stands nowhere spoils its own tets; one in the plane of a face flattens them."""
    mesh = box((3, 3, 3), jitter=0.2)
    options: dict[str, Any] = {"precision": precision, "time_step": 0.01}
    options |= {"material": Material(volume=volume)}
    spoiled = []
    for native in (True, False):
        body = rig(mesh, native_code=native, **options)
        points = crumpled(mesh, amount=0.08)
        flat, lost = mesh.tets[40], mesh.tets[7][0]
        points[flat[0]] = points[flat[1:]].mean(axis=0)
        points[lost] = np.nan
        body.place(points)
        body.stepper.assemble(body.state)
        spoiled.append(numbers(body.stepper.assembly.impulses))
    around = np.unique(mesh.tets[(mesh.tets == mesh.tets[7][0]).any(axis=1)])
    beside = np.setdiff1d(np.arange(len(mesh.points)), around)
    for impulses in spoiled:
        assert np.isnan(impulses[around]).all(axis=1).all() and np.isfinite(impulses[beside]).all()
    same([spoiled[0][beside]], [spoiled[1][beside]], precision)


@pytest.mark.parametrize("volume", ["exact", "linear"])
def test_any_number_of_threads_gives_the_same_bits(volume: Any) -> None:
    mesh = box((3, 3, 3), jitter=0.2)
    found = [
        assembled(mesh, amount=0.8, material=Material(volume=volume), threads=threads)
        for threads in (1, 2, 3)
    ]
    for others in found[1:]:
        for own, other in zip(found[0], others, strict=True):
            np.testing.assert_array_equal(own, other)


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
