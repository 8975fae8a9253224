"""Extruded outlines: closed, of the right volume, whatever way they turn."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.meshing.tetgen_mesher import tetgen_version
from warp_softbody.characters.outline import extruded_outline
from warp_softbody.errors import InputError

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
LETTER_U = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
SPIKE = [(0, 0), (4, 0), (4, 1), (2.05, 0.02), (2, 2), (1.95, 0.02), (0, 1)]


def ring(radius: float, corners: int) -> NDArray[np.float64]:
    """Corners (k, 2) of a regular polygon."""
    angles = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def polygon_area(corners: NDArray[np.float64]) -> float:
    """Area by the shoelace rule."""
    x, z = corners.T
    return abs(float(x @ np.roll(z, -1) - z @ np.roll(x, -1))) / 2.0


@pytest.mark.parametrize("size", [0.11, 0.4, 5.0])
@pytest.mark.parametrize("outline", [SQUARE, LETTER_U, SPIKE, ring(1.0, 17)])
@pytest.mark.parametrize("direction", [1, -1])
def test_closed_with_the_outlines_volume(
    outline: list[tuple[float, float]], size: float, direction: int
) -> None:
    corners = np.array(outline, dtype=np.float64)[::direction]
    surface = extruded_outline(corners, (-0.2, 0.3), size)
    assert surface.is_watertight and surface.is_winding_consistent
    assert surface.volume == pytest.approx(0.5 * polygon_area(corners), rel=1e-12)
    np.testing.assert_allclose(surface.bounds[:, 1], [-0.2, 0.3])


@pytest.mark.parametrize("size", [0.08, 0.5])
def test_letter_o(size: float) -> None:
    outer, inner = ring(0.5, 24), ring(0.35, 24)
    surface = extruded_outline(outer, (-0.1, 0.1), size, holes=[inner])
    assert surface.is_watertight and surface.is_winding_consistent
    assert surface.volume == pytest.approx(0.2 * (polygon_area(outer) - polygon_area(inner)))
    # A torus has Euler number 0.
    assert surface.euler_number == 0


@pytest.mark.skipif(tetgen_version() is None, reason="TetGen is an optional extra")
def test_letter_o_meshes() -> None:
    surface = extruded_outline(ring(0.5, 24), (-0.1, 0.1), 0.1, holes=[ring(0.35, 24)])
    mesh = TetMesh.from_surface(surface, mesher="tetgen", size=0.1)
    assert mesh.volume == pytest.approx(surface.volume, rel=1e-9)


def test_size_sets_the_edges() -> None:
    surface = extruded_outline(SQUARE, (0.0, 1.0), 0.25)
    bottom = np.unique(surface.vertices[surface.vertices[:, 2] == 0.0].round(12), axis=0)
    grid = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(bottom[:, :2], [(x, y) for x in grid for y in grid])
    assert surface.edges_unique_length.max() < 1.6 * 0.25


@pytest.mark.parametrize(
    ("outline", "y_range", "size", "sentence"),
    [
        (SQUARE[:2], (0.0, 1.0), 0.1, r"needs corners of shape \(k >= 3, 2\), got \(2, 2\)"),
        ([*SQUARE[:3], (0.0, np.nan)], (0.0, 1.0), 0.1, "corners that are not finite"),
        ([(0, 0), (1, 1), (2, 2)], (0.0, 1.0), 0.1, "encloses no area"),
        (SQUARE, (1.0, 1.0), 0.1, "a rising y_range"),
        (SQUARE, (0.0, 1.0), 0.0, "a positive size"),
        ([(0, 0), (2, 2), (2, 0), (0, 3)], (0.0, 1.0), 0.5, "its loops cross or touch"),
    ],
)
def test_refusals(
    outline: list[tuple[float, float]], y_range: tuple[float, float], size: float, sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        extruded_outline(outline, y_range, size)
