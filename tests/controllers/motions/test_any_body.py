"""Motions of bodies that nobody prepared: what they need, and that most stand a push."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from tests.support.surfaces import BODIES
from warp_softbody import Character, Plane, Push, Scene, Simulation, characters, controllers
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.controllers.motions.any_body import feet_of
from warp_softbody.errors import InputError, MeshWarning

PUSH = 0.15
"""Body weights at the head, for 0.2 s."""


def named(**regions: int) -> Character:
    """The letter with regions of so many nodes."""
    letter = characters.letter_i()
    own = {name: np.arange(count, dtype=np.int32) for name, count in regions.items()}
    return Character(name="letter", mesh=letter.mesh, muscles=letter.muscles, regions=own)


def test_a_body_lacks_a_region() -> None:
    with pytest.raises(InputError, match="Balance needs nodes in the region 'head'"):
        controllers.Balance.for_(named(base=3))
    with pytest.raises(InputError, match="Balance needs nodes in the region 'base'"):
        controllers.Balance.for_(named(base=0, head=3))


def test_a_body_lacks_muscles() -> None:
    passive = replace(named(base=3, head=3), muscles=())
    with pytest.raises(InputError, match="Balance needs muscles, but character 'letter' has none"):
        controllers.Balance.for_(passive)


def test_feet() -> None:
    assert feet_of(named(base=3)) == ("base",)
    assert feet_of(named(base=3, base_patch_0=1, base_patch_1=0)) == ("base_patch_0",)
    two = {"foot_0": 1, "foot_1": 1, "base_patch_0": 1, "base_patch_1": 1}
    assert feet_of(named(**two)) == ("base_patch_0", "base_patch_1")
    assert feet_of(named(**two, foot_2=1)) == ("foot_0", "foot_1", "foot_2")


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(BODIES.keys() - {"capsule", "biped"}))
def test_stands_a_push(name: str) -> None:
    """No fibre is placed and no gain is set by hand; `capsule` wanders and `biped` shakes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        character = Character.from_surface(BODIES[name](), name=name)
    mesh = character.mesh
    mass = character.material.density * lumped_masses(mesh.tets, mesh.volumes, len(mesh.points))
    force = (PUSH * 9.81 * float(mass.sum()), 0.0, 0.0)
    push = Push(region="head", force=force, start=0.5, duration=0.2)
    scene = Scene(character=character, ground=Plane(), pushes=(push,))
    simulation = Simulation(scene, controllers.Balance.for_(character), time_step=1 / 60)
    *_, last = simulation.run(5.0)
    share = mass / mass.sum()
    start, end = share @ mesh.points, share @ last.positions
    assert np.linalg.norm(end[:2] - start[:2]) < 0.3
    assert end[2] > 0.85 * start[2]
    assert abs(last.velocities).max() < 0.1
