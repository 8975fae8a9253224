"""Vertices of fibres in the mesh, at its skin and outside."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.typing import NDArray

from warp_softbody.body.character import Character
from warp_softbody.body.fiber_embedding import embed, nearest_on_triangles
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup
from warp_softbody.engine.muscle_layout import build_muscle_layout
from warp_softbody.errors import InputError, MeshWarning


def places(mesh: TetMesh, points: list[list[float]]) -> NDArray[np.float64]:
    """Where the weights put the points."""
    found = embed(mesh, np.array(points), ["f"] * len(points))
    np.testing.assert_allclose(found.weights.sum(axis=1), 1.0, atol=1e-12)
    return np.asarray(np.einsum("pk,pkx->px", found.weights, mesh.points[found.nodes]))


def test_inner_vertices_stay_where_they_are(cube: TetMesh) -> None:
    inner = np.random.default_rng(0).uniform(0.0, 1.0, (20, 3)).tolist()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_allclose(places(cube, inner), inner, atol=1e-12)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e3])
def test_a_vertex_just_outside_is_moved_onto_the_surface(cube: TetMesh, scale: float) -> None:
    mesh = TetMesh(scale * cube.points, cube.tets)
    outside = [[0.3, 0.6, 1.004], [1.003, 0.5, 1.004], [1.002, 1.002, 1.002]]
    sentence = rf"3 vertices of fibres .* by at most {0.005 * scale:.3g} m \(fibre 'f'\)"
    with pytest.warns(MeshWarning, match=sentence):
        found = places(mesh, (scale * np.array(outside)).tolist())
    right = np.array([[0.3, 0.6, 1.0], [1.0, 0.5, 1.0], [1.0, 1.0, 1.0]])
    np.testing.assert_allclose(found, scale * right, atol=1e-12 * scale)


@pytest.mark.parametrize("scale", [1e-6, 1.0])
def test_a_vertex_far_outside_is_refused_with_its_distance(cube: TetMesh, scale: float) -> None:
    mesh = TetMesh(scale * cube.points, cube.tets)
    sentence = rf"lies outside the mesh, {0.1 * scale:.3g} m from it; at most {0.00866 * scale:.3g}"
    with pytest.raises(InputError, match=rf"fibre 'f': vertex .* m {sentence}"):
        embed(mesh, scale * np.array([[0.5, 0.5, 1.1]]), ["f"])


def test_rest_lengths_are_those_of_the_moved_vertices(cube: TetMesh) -> None:
    vertices = np.array([[0.2, 0.5, 1.003], [0.5, 0.5, 1.0], [0.8, 0.5, 0.8]])
    fiber = Fiber(vertices=vertices, kind=FiberKind.LONGITUDINAL, name="f")
    group = MuscleGroup(fibers=(fiber,), strength=1e5, kernel_width=0.3, name="g")
    with pytest.warns(MeshWarning):
        layout = build_muscle_layout(Character(name="cube", mesh=cube, muscles=(group,)))
    np.testing.assert_allclose(layout.rest_lengths, [0.3, np.hypot(0.3, 0.2)], atol=1e-12)


def test_nearest_place_on_a_triangle() -> None:
    triangle = np.array([[[0.0, 0, 0], [2, 0, 0], [0, 2, 0]]])
    for point, weights in (
        ([0.5, 0.5, 3.0], [0.5, 0.25, 0.25]),
        ([1.0, -1.0, 0.0], [0.5, 0.5, 0.0]),
        ([2.0, 2.0, 1.0], [0.0, 0.5, 0.5]),
        ([-1.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
    ):
        _, found = nearest_on_triangles(triangle, np.array(point))
        np.testing.assert_allclose(found, weights, atol=1e-12)
