"""Fibres and regions by hand: on a block whose shape is known."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.support.bodies import box
from warp_softbody import Character, FiberKind, MuscleGroup, TetMesh, muscles, regions
from warp_softbody.errors import InputError, MeshError, MeshWarning

SIZE = (0.2, 0.3, 1.0)
BLOCK = TetMesh(
    box((2, 3, 10), SIZE).points,
    box((2, 3, 10), SIZE).tets,
    regions={"all": np.arange(len(box((2, 3, 10), SIZE).points), dtype=np.int32)},
)


def test_along_a_line() -> None:
    line = [(0.1, 0.15, 0.1), (0.1, 0.15, 0.9)]
    fiber = muscles.along(BLOCK, line, segments=4)
    assert fiber.kind is FiberKind.LONGITUDINAL
    np.testing.assert_allclose(fiber.vertices[:, 2], [0.1, 0.3, 0.5, 0.7, 0.9])
    np.testing.assert_allclose(muscles.along(BLOCK, line).vertices, line)


def test_along_a_region() -> None:
    fiber = muscles.along(BLOCK, "all", segments=5, name="spine")
    np.testing.assert_allclose(fiber.vertices[:, :2], [(0.1, 0.15)] * 6, atol=0.02)
    assert (np.diff(fiber.vertices[:, 2]) > 0.1).all()
    top = regions.where(BLOCK, lambda p: p[:, 2] > 0.45)
    assert muscles.along(BLOCK, top).vertices[:, 2].min() > 0.4


@pytest.mark.parametrize("depth", [0.0, 0.4])
def test_a_ring_keeps_its_depth_below_the_skin(depth: float) -> None:
    fiber = muscles.ring(BLOCK, (0.1, 0.15, 0.5), (0.0, 0.0, 2.0), segments=16, depth=depth)
    assert fiber.kind is FiberKind.RADIAL
    np.testing.assert_array_equal(fiber.vertices[0], fiber.vertices[-1])
    arms = fiber.vertices - (0.1, 0.15, 0.5)
    # of a rectangle, whatever the angle: one of both sides is reached
    shares = np.maximum(abs(arms[:, 0]) / 0.1, abs(arms[:, 1]) / 0.15)
    np.testing.assert_allclose(shares, 1.0 - depth, atol=1e-6)
    np.testing.assert_allclose(arms[:, 2], 0.0, atol=1e-6)


def test_a_helix_winds_about_its_axis() -> None:
    ends = (0.1, 0.15, 0.2), (0.1, 0.15, 0.8)
    fiber = muscles.helix(BLOCK, *ends, turns=1.5, segments=60)
    assert fiber.kind is FiberKind.HELICAL
    np.testing.assert_allclose(fiber.vertices[:, 2], np.linspace(0.2, 0.8, 61))
    x, y = (fiber.vertices[:, :2] - (0.1, 0.15)).T
    turned = np.unwrap(np.arctan2(y, x))
    assert turned[-1] - turned[0] == pytest.approx(1.5 * 2.0 * np.pi)
    back = muscles.helix(BLOCK, *ends, turns=-1.5, segments=60).vertices
    np.testing.assert_allclose(back[0], fiber.vertices[0])


def test_a_vertex_just_outside_is_moved_in() -> None:
    line = [(0.1, 0.15, 0.1), (0.1, 0.15, 1.002)]
    with pytest.warns(MeshWarning, match="1 vertex of fibres lay outside"):
        fiber = muscles.along(BLOCK, line, name="up")
    assert fiber.vertices[-1, 2] == pytest.approx(1.0)
    with pytest.raises(InputError, match=r"fibre 'up': vertex .* lies outside the mesh"):
        muscles.along(BLOCK, [(0.1, 0.15, 0.1), (0.1, 0.15, 1.2)], name="up")
    with pytest.raises(InputError, match="the axis of ring must lie in the mesh"):
        muscles.ring(BLOCK, (0.5, 0.15, 0.5), (0.0, 0.0, 1.0))


def test_a_segment_outside_is_told() -> None:
    """Across the gap of two cubes that a bar joins at the bottom, 0.4 m wide and as deep."""
    points = np.array(box((5, 1, 5), (1.0, 0.2, 1.0)).points)
    tets = np.array(box((5, 1, 5), (1.0, 0.2, 1.0)).tets)
    middles = points[tets].mean(axis=1)
    gap = (abs(middles[:, 0] - 0.5) < 0.3) & (middles[:, 2] > 0.2)
    used, left = np.unique(tets[~gap], return_inverse=True)
    horseshoe = TetMesh(points[used], left.reshape(-1, 4).astype(np.int32))
    across = [(0.1, 0.1, 0.6), (0.9, 0.1, 0.6)]
    # in the middle of the gap, 0.3 m from its walls; sampled every 0.0286 m
    with pytest.warns(MeshWarning, match=r"fibre 'bow' leaves the mesh .* by 0\.29 m at \(0\.486,"):
        muscles.along(horseshoe, across, segments=1, name="bow")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        muscles.along(horseshoe, [(0.1, 0.1, 0.9), (0.1, 0.1, 0.1), (0.9, 0.1, 0.1)])


def test_a_helix_has_six_segments_a_turn() -> None:
    ends = (0.1, 0.15, 0.2), (0.1, 0.15, 0.8)
    muscles.helix(BLOCK, *ends, turns=-4.0, segments=24)
    with pytest.raises(InputError, match="at least 144 for 24 turns, 6 a turn, not 24"):
        muscles.helix(BLOCK, *ends, turns=24, segments=24)


def test_wrong_paths_are_told() -> None:
    with pytest.raises(InputError, match="the mesh has no region 'arm'; its regions are: all"):
        muscles.along(BLOCK, "arm")
    with pytest.raises(InputError, match="path of along must be two points or more"):
        muscles.along(BLOCK, [(0.1, 0.1, 0.1)])
    with pytest.raises(InputError, match="start and end of helix must be two places"):
        muscles.helix(BLOCK, (0.1, 0.1, 0.1), (0.1, 0.1, 0.1))


def test_curves_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "curves.obj"
    path.write_text(
        "# two curves, in cm\no left\nv 5 15 10\nv 5 15 50\nv 5 15 90\nl 1 2 3\n"
        "o right\nv 15 15 10\nv 15 15 90\nl -2 -1\nl 4 5\n"
    )
    left, right, again = muscles.read_curves(path, unit=0.01)
    assert [left.name, right.name, again.name] == ["left", "right", "right_1"]
    np.testing.assert_allclose(left.vertices[1], (0.05, 0.15, 0.5))
    np.testing.assert_allclose(right.vertices, again.vertices)
    group = MuscleGroup(fibers=(left, right), strength=1e5, kernel_width=0.05, name="hands")
    assert Character(name="block", mesh=BLOCK, muscles=(group,)).segment_count == 3
    path.write_text("v 0 0 0\nl 1 7\n")
    with pytest.raises(MeshError, match="line 2: there is no vertex 7 among 1"):
        muscles.read_curves(path)
    path.write_text("v 0 0 0\n")
    with pytest.raises(MeshError, match="holds no polyline"):
        muscles.read_curves(path)
    with pytest.raises(MeshError, match="cannot be read"):
        muscles.read_curves(tmp_path / "none.obj")


def test_where_a_condition_holds() -> None:
    points = BLOCK.points
    high = points[:, 2] > 0.75
    wanted = np.flatnonzero(high)
    for mask in (high, high.astype(int), high.astype(float), list(high), high.astype(object)):
        np.testing.assert_array_equal(regions.where(BLOCK, mask), wanted)
    np.testing.assert_array_equal(regions.where(BLOCK, lambda p: p[:, 2] > 0.75), wanted)
    skin = regions.where(BLOCK, high, skin=True)
    assert set(skin) == set(wanted) & set(BLOCK.surface_nodes)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for wrong, sentence in (
            (lambda p: p[:, 2] > 9.0, "holds for no node"),
            (lambda p: True, "must return a truth value for each of"),
            ("head", "condition of where must be node indices"),
        ):
            with pytest.raises(InputError, match=sentence):
                regions.where(BLOCK, wrong)
