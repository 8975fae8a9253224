"""Tets reach all limbs of a solid, however many of them that takes."""

from __future__ import annotations

import numpy as np
import pytest
from trimesh import creation

from tests.support.surfaces import BODIES, joined, limb
from warp_softbody import Character
from warp_softbody.body.making.coverage import Coverage
from warp_softbody.body.making.filling import Filling, fill
from warp_softbody.body.making.lattice import Filled
from warp_softbody.body.making.octree import Octree
from warp_softbody.body.making.solid import Solid, solid_of
from warp_softbody.errors import MeshError, MeshWarning

BODY = creation.icosphere(subdivisions=2, radius=0.3)


def with_limbs(count: int, radius: float, length: float = 0.8) -> Solid:
    """A ball with limbs all round."""
    angles = 2.0 * np.pi * np.arange(count) / count
    ends = length * np.stack([np.cos(angles), np.sin(angles), -0.3 + 0.0 * angles], axis=1)
    whole = joined(BODY, *(limb((0.0, 0.0, 0.0), tuple(end), radius) for end in ends))
    return solid_of(np.array(whole.vertices), np.array(whole.faces), "octopus")


def missed(solid: Solid, filling: Filling) -> float:
    """Length, m, by which the tets miss the tips of the limbs."""
    tips = solid.points[np.linalg.norm(solid.points, axis=1) > 0.8]
    distances = np.linalg.norm(tips[:, None] - filling.points[None], axis=2)
    return float(distances.min(axis=1).max())


@pytest.mark.parametrize(("count", "radius", "most"), [(3, 0.05, 2200), (8, 0.08, 2500)])
def test_no_limb_is_lost(count: int, radius: float, most: int) -> None:
    solid = with_limbs(count, radius)
    filling = fill(solid, 600)
    assert len(filling.tets) < most
    assert missed(solid, filling) < 1.5 * radius


def test_few_tets_where_few_do() -> None:
    assert len(fill(with_limbs(8, 0.15), 1500).tets) == pytest.approx(1500, rel=0.2)


def test_a_thin_fin_is_carried_by_the_skin() -> None:
    fin = creation.box((0.2, 0.08, 0.012))
    fin.apply_translation((0.27, 0.0, 0.0))
    fish = joined(BODY, fin)
    told = r"2 parts united, a part near \(0\.3\d*, .*\) m is too thin for tets"
    with pytest.warns(MeshWarning, match=told):
        character = Character.from_surface(fish, name="fish", tets=6000)
    assert len(character.mesh.tets) < 8000
    assert character.mesh.skin is not None
    assert character.mesh.skin.points[:, 0].max() > 0.36


def test_a_part_of_hardly_any_volume_is_told() -> None:
    """A fin of 1 mm and a hair, in which no place of those lies by which tets are judged."""
    fin, hair = creation.box((0.2, 0.08, 0.001)), creation.cylinder(radius=0.002, height=0.3)
    fin.apply_translation((0.37, 0.0, 0.0))
    hair.apply_translation((0.0, 0.0, 0.4))
    for part, axis, end in ((fin, 0, 0.47), (hair, 2, 0.55)):
        whole = joined(BODY, part)
        solid = solid_of(np.array(whole.vertices), np.array(whole.faces), "ball")
        place = fill(solid, 1500).missed
        assert place is not None
        assert place[axis] == pytest.approx(end)


@pytest.mark.parametrize("name", ["biped", "chair"])
def test_edges_that_a_lattice_cuts_are_no_parts(name: str) -> None:
    """Of the ten surfaces those that are cut the most."""
    surface = BODIES[name]()
    solid = solid_of(np.array(surface.vertices), np.array(surface.faces), name)
    assert fill(solid, 1500).missed is None


def test_a_long_limb_too_thin_by_far_is_told() -> None:
    with pytest.raises(MeshError, match=r"only 9\d% of the body .* limbs too thin for so few"):
        fill(with_limbs(3, 0.012, length=1.5), 200)


def test_what_is_missed_is_measured() -> None:
    solid = with_limbs(4, 0.09)
    filling = fill(solid, 1500)
    whole = filling.points[filling.tets].mean(axis=1)
    # without the limb along +x
    fewer = filling.tets[whole[:, 0] < 0.35]
    low, high = solid.bounds
    tree = Octree.around(low, high, 0.05)
    unreached = Coverage(solid).unreached(Filled(filling.points, fewer), tree)
    volume = np.pi * 0.09**2 * (np.hypot(0.8, 0.3) - 0.35)
    total = 4.0 / 3.0 * np.pi * 0.3**3 + 4.0 * np.pi * 0.09**2 * (np.hypot(0.8, 0.3) - 0.3)
    assert unreached.share == pytest.approx(volume / total, rel=0.3)
    assert unreached.farthest[0] > 0.75
    assert not unreached.little
