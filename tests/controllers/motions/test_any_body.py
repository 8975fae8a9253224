"""Motions of bodies that nobody prepared: what they need, and that most stand a push."""

from __future__ import annotations

import warnings
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from trimesh import creation

from tests.support.surfaces import BODIES, at, joined, limb
from warp_softbody import Character, Plane, Push, Scene, Simulation, characters, controllers
from warp_softbody.body.mesh_geometry import lumped_masses
from warp_softbody.controllers.motions.any_body import feet_of
from warp_softbody.controllers.motions.balance_gains import ANY_BODY
from warp_softbody.controllers.motions.for_any_body.support import hull, reach, room
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
@pytest.mark.parametrize("name", sorted(BODIES.keys() - {"capsule"}))
def test_stands_a_push(name: str) -> None:
    """No fibre is placed and no gain is set by hand; `capsule` wanders on its round end."""
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


def octopus() -> Any:
    """A ball on four bent arms, none of which is steep."""
    angles = 2.0 * np.pi * np.arange(4) / 4.0
    parts = [at(creation.icosphere(subdivisions=2, radius=0.35), (0.0, 0.0, 0.6))]
    for x, y in zip(np.cos(angles), np.sin(angles), strict=True):
        knees = [(0.25, 0.45), (0.55, 0.3), (0.8, 0.08), (1.05, 0.07)]
        places = [(float(r * x), float(r * y), z) for r, z in knees]
        parts += [limb(a, b, 0.075) for a, b in pairwise(places)]
    return joined(*parts)


def test_comes_to_rest_where_it_stands() -> None:
    """As firm as the body's limbs ask, whichever way they go: it neither sinks nor shakes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        character = Character.from_surface(octopus(), name="body", tets=600)
    scene = Scene(character=character, ground=Plane())
    simulation = Simulation(scene, controllers.Balance.for_(character), time_step=1 / 60)
    *_, last = simulation.run(1.0)
    rest = character.mesh.points
    assert last.positions[:, 2].mean() > 0.95 * rest[:, 2].mean()
    assert abs(last.velocities).max() < 0.1


def test_room_on_a_sole() -> None:
    """A rectangle of 0.4 by 0.2 m, 0.1 m above z = 0, under a point 0.5 m higher."""
    sole = np.array([(x, y, 0.1) for x in (0.0, 0.2, 0.4) for y in (0.0, 0.2)])
    for x, y, wanted in ((0.2, 0.1, 0.1), (0.2, 0.15, 0.05), (0.45, 0.1, -0.05)):
        assert room(sole, np.array([x, y, 0.6])) == pytest.approx(wanted / 0.5)
    assert room(sole[::2], np.array([0.2, 0.0, 0.6])) == 0.0


def test_reach_of_a_sole() -> None:
    """From a point within a rectangle of 0.4 by 0.2 m to its edges."""
    corners = hull(np.array([(x, y) for x in (-0.1, 0.3) for y in (-0.1, 0.1)]))
    for way, wanted in (((2.0, 0.0), 0.3), ((-1.0, 0.0), 0.1), ((3.0, 3.0), 0.1 * np.sqrt(2.0))):
        assert reach(corners, np.array(way)) == pytest.approx(wanted)
    assert reach(corners, np.zeros(2)) == np.inf
    assert reach(corners + 1.0, np.array([-1.0, 0.0])) == 0.0
    assert reach(corners[:2], np.array([1.0, 0.0])) == 0.0


def test_feet_stay_until_the_capture_point_is_near_their_edge() -> None:
    """What is asked of the base's velocity under the head, as the body moves on faster."""
    letter = characters.letter_h()
    balance = controllers.Balance.for_(letter, replace(ANY_BODY, base_weight=0.0))
    own = Simulation(Scene(character=letter, ground=Plane()), time_step=1 / 60).view()
    nodes, shares = letter.region("base"), []
    deep = float(np.ptp(letter.mesh.points[nodes, 1])) / 2.0
    fall = np.sqrt(9.81 / own.center_of_mass[2])
    for share in (0.0, 0.55, 0.8, 1.1):
        moving = np.zeros_like(own.velocities)
        moving[:, 1] = share * deep * fall
        (upright,) = (
            o
            for o in balance.goals(replace(own, velocities=moving)).objectives
            if o.name == "upright"
        )
        rows = upright.rows[1].reshape(-1, 3)[:, 1]
        shares.append(-rows[nodes].sum() * 9.81 / 60)
    assert shares == pytest.approx([0.0, 0.0, 0.5, 1.0], abs=0.02)


def test_a_narrow_sole_is_not_left() -> None:
    """A dumbbell stands by itself on a sole of a sixth of the height of its centre of mass."""
    balls = [creation.icosphere(subdivisions=2, radius=0.25) for _ in range(2)]
    for ball, height in zip(balls, (0.25, 1.05), strict=True):
        ball.apply_translation((0.0, 0.0, height))
    bar = creation.cylinder(radius=0.1, segment=[(0, 0, 0.2), (0, 0, 1.1)], sections=16)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        character = Character.from_surface(balls[0] + balls[1] + bar, name="dumbbell")
    scene = Scene(character=character, ground=Plane())
    simulation = Simulation(scene, controllers.Balance.for_(character), time_step=1 / 60)
    for _ in range(240):
        simulation.step()
    moved = simulation.state.positions.numpy() - character.mesh.points
    assert np.abs(moved).max() < 0.02
