"""What is inside of flawed surfaces: parts, holes, turned triangles, cavities."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from trimesh import creation

from tests.support.surfaces import at, joined
from warp_softbody.body.making.filling import fill
from warp_softbody.body.making.solid import Solid, solid_of
from warp_softbody.body.mesh_geometry import tet_volumes
from warp_softbody.errors import MeshError


def solid(surface: Any) -> Solid:
    """Of a trimesh surface."""
    faces = np.array(surface.faces, dtype=np.int64)
    return solid_of(np.array(surface.vertices, dtype=np.float64), faces, "given")


def box(side: float = 1.0) -> Any:
    """A cube around the origin, of 768 triangles."""
    return creation.box((side, side, side)).subdivide().subdivide().subdivide()


def test_a_whole_surface_needs_no_repair() -> None:
    assert solid(box()).repairs == ()


def test_distance_is_positive_inside() -> None:
    places = np.array([[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.7, 0.0, 0.0], [0.0, 0.0, -1.0]])
    assert solid(box()).distance(places) == pytest.approx([0.5, 0.1, -0.2, -0.5], abs=1e-9)


def test_parts_that_cross_are_united() -> None:
    united = solid(joined(box(), at(box(), (0.53, 0.02, 0.01))))
    assert united.repairs == ("2 parts united",)
    assert united.distance(np.array([[0.25, 0.0, 0.0]]))[0] > 0.0
    points, tets, *_ = fill(united, 2000)
    overlap = 0.47 * 0.98 * 0.99
    assert tet_volumes(points, tets).sum() == pytest.approx(2.0 - overlap, rel=0.03)


def test_holes_are_closed() -> None:
    whole = box()
    whole.update_faces(np.arange(len(whole.faces)) % 40 != 0)
    holed = solid(whole)
    assert "open edges closed" in holed.repairs[0]
    assert holed.distance(np.zeros((1, 3)))[0] > 0.3
    assert holed.distance(np.array([[0.0, 0.0, 0.8]]))[0] < 0.0


def test_triangles_that_are_turned_are_turned_back() -> None:
    surface = box()
    faces = np.array(surface.faces)
    faces[::3] = faces[::3, ::-1]
    turned = solid_of(np.array(surface.vertices), faces.astype(np.int64), "given")
    assert "disagreed" in turned.repairs[0]
    assert turned.distance(np.zeros((1, 3)))[0] == pytest.approx(0.5)


def test_a_part_that_is_inside_out_is_turned() -> None:
    surface = box()
    surface.invert()
    assert solid(surface).repairs == ("1 part turned inside out",)
    assert solid(surface).distance(np.zeros((1, 3)))[0] == pytest.approx(0.5)


def test_a_cavity_stays_hollow() -> None:
    inner = box(0.5)
    inner.invert()
    hollow = solid(joined(box(), inner))
    assert hollow.distance(np.zeros((1, 3)))[0] < 0.0
    assert hollow.distance(np.array([[0.4, 0.0, 0.0]]))[0] > 0.0


def test_parts_that_do_not_touch_are_refused() -> None:
    apart = solid(joined(box(), at(box(), (3.0, 0.0, 0.0))))
    with pytest.raises(MeshError, match="parts that do not touch"):
        fill(apart, 1000)


@pytest.mark.parametrize("tets", [300, 1500, 3000])
def test_as_many_tets_as_are_asked_for(tets: int) -> None:
    points, made, *_ = fill(solid(at(creation.capsule(0.6, 0.2), (0.0, 0.0, 0.0))), tets)
    assert len(made) == pytest.approx(tets, rel=0.2)
    volume = np.pi * 0.2**2 * (0.6 + 4.0 / 3.0 * 0.2)
    assert tet_volumes(points, made).sum() == pytest.approx(volume, rel=0.03)


def test_a_flat_surface_encloses_nothing() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    flat = solid_of(points, np.array([[0, 1, 2], [1, 3, 2]]), "given")
    with pytest.raises(MeshError, match="encloses no volume"):
        fill(flat, 1000)
