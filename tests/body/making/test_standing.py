"""What a body stands on and how firm it is, on any mesh of it: soles, feet, sagging, swaying."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from tests.support.bodies import box
from tests.support.surfaces import BODIES
from warp_softbody.body.making.firmness import MOST_TIMES, OWN_WEIGHT, SAG, SWAY, firm_material
from warp_softbody.body.making.from_surface import made_from_surface
from warp_softbody.body.making.limb_fibers import _frames
from warp_softbody.body.making.limbs import Limb
from warp_softbody.body.making.made import Made
from warp_softbody.body.making.sagging import yielding
from warp_softbody.body.making.soles import broad_soles
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.mesh_geometry import tet_volumes
from warp_softbody.errors import MeshWarning


def made(name: str, tets: int) -> Made:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return made_from_surface(BODIES[name](), name=name, tets=tets)


@pytest.mark.parametrize("tets", [800, 1500, 3000])
def test_a_starfish_has_its_five_arms_as_feet_on_every_mesh(tets: int) -> None:
    """Pieces of its bumpy underside were two, five or seven."""
    feet = [name for name in made("starfish", tets).regions if name.startswith("foot_")]
    assert len(feet) == 5


@pytest.mark.parametrize("tets", [800, 1500])
def test_round_feet_have_soles_on_coarse_meshes(tets: int) -> None:
    """Legs that end in a ball, of which the mesh has a node or two."""
    body = made("quadruped", tets)
    for foot in range(4):
        sole = body.mesh.points[body.regions[f"foot_{foot}"]]
        assert (sole[:, 2] == 0.0).all()
        across = np.linalg.svd(sole[:, :2] - sole[:, :2].mean(axis=0), compute_uv=False)
        assert across.min() > 0.04


def test_a_tip_that_would_be_flattened_is_taken_off() -> None:
    """A pyramid on its apex, under a block: its base square becomes the sole."""
    apex = np.array([[0.55, 0.5, 0.0]])
    ring = np.array([[0.0, 0.0, 0.3], [1.0, 0.0, 0.3], [1.0, 1.0, 0.3], [0.0, 1.0, 0.3]])
    points = np.concatenate([apex, ring, ring + np.array([0.0, 0.0, 9.7])])
    prism = [[1, 2, 3, 7], [1, 2, 7, 6], [1, 6, 7, 5], [1, 3, 4, 7], [1, 4, 8, 7], [1, 8, 5, 7]]
    tets = np.array([[0, 1, 3, 2], [0, 1, 4, 3], *prism], dtype=np.int32)
    volumes = tet_volumes(points, tets)
    tets[volumes < 0.0] = tets[volumes < 0.0][:, [0, 1, 3, 2]]
    flat = broad_soles(points, tets)
    assert list(flat.nodes) == list(range(1, 9))
    assert (flat.points[:4, 2] == 0.0).all()
    assert tet_volumes(flat.points, flat.tets).sum() == pytest.approx(10.0)


def test_a_block_sags_as_a_rod() -> None:
    """Of a rod under its own weight the centre of mass goes down by rho g h^2 / 3 E."""
    mesh = box((4, 4, 12), (0.1, 0.1, 0.3))
    weight = 7.0
    found = yielding(mesh, mesh.points[:, 2] == 0.0, 0.0, weight)
    assert found.height == pytest.approx(0.15, rel=1e-6)
    assert found.sag == pytest.approx(weight * 0.3 / (3.0 * 0.1**2), rel=2e-2)


def test_a_slender_bar_sways_as_a_beam() -> None:
    """Under its weight aside: q h^4 / 20 E I and, by shear, q h^2 / 3 k G A (Timoshenko)."""
    errors, (side, height, weight) = [], (0.1, 0.5, 3.0)
    beam = weight * height**3 / (20.0 * side**4 / 12.0)
    shear = weight * height * 2.0 / (3.0 * (5.0 / 6.0) * side**2)
    for cells in (2, 4, 8):
        mesh = box((cells, cells, 5 * cells), (side, side, height))
        found = yielding(mesh, mesh.points[:, 2] == 0.0, 0.0, weight)
        errors.append(1.0 - found.sway / (beam + shear))
    # linear tets are too stiff in bending, by the square of their size
    assert 0.0 < errors[2] < 0.08
    assert errors[1] / errors[2] > 2.5


def test_a_body_is_as_firm_as_its_legs_ask() -> None:
    """It neither sags nor sways more than it may, on any mesh of it."""
    for tets in (800, 1500):
        body = made("table", tets)
        mesh = body.mesh
        held = np.zeros(len(mesh.points), dtype=bool)
        held[body.regions["base"]] = True
        weight = 1000.0 * mesh.volume * 9.81
        found = yielding(mesh, held, body.material.poisson_ratio, weight)
        # the modulus is rounded to two digits
        assert found.sag / body.material.young_modulus < 1.05 * SAG * found.height
        assert found.sway / body.material.young_modulus < 1.05 * SWAY * found.height


def test_what_stands_on_a_point_is_no_firmer_for_it() -> None:
    points = np.array([[0, 0, 0], [1, 0, 2], [-1, 1, 2], [-1, -1, 2]], dtype=float)
    mesh = TetMesh(points, np.array([[0, 1, 2, 3]], dtype=np.int32))
    usual = OWN_WEIGHT * 1000.0 * 9.81 * 2.0
    assert firm_material(mesh, (), density=1000.0, on_feet=True).young_modulus == pytest.approx(
        usual, rel=0.05
    )
    wobbling = np.array([[0, 0, 0], [0.03, 0, 0], [0, 0.03, 0], [0, 0, 2]], dtype=float)
    mesh = TetMesh(wobbling, np.array([[0, 1, 2, 3]], dtype=np.int32))
    firmest = MOST_TIMES * usual
    assert firm_material(mesh, (), density=1000.0, on_feet=True).young_modulus <= 1.05 * firmest


def test_a_limb_without_a_node_of_its_own_gets_fibres() -> None:
    """A coarse mesh may have none within the slices of a thin limb."""
    axis = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.7], [0.0, 0.0, 0.9]])
    limb = Limb(axis, np.zeros(0, dtype=np.int64), 0.1, ends=True)
    frames = _frames(box(), limb, axis)
    assert np.linalg.norm(frames, axis=2) == pytest.approx(1.8 * 0.1 / np.sqrt(2.0))
