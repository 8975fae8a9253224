"""Patches on a ground whose friction differs from place to place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.support.blocks import SIZE, block, seen
from warp_softbody.controllers.patches import ground_patches
from warp_softbody.world.friction_map import FrictionMap
from warp_softbody.world.ground import Plane


def test_a_patch_has_the_mean_of_what_its_nodes_stand_on() -> None:
    """The stripe begins under a quarter of the foot: by symmetry of its shares of area."""
    character = block()
    x = character.mesh.points[:, 0]
    # between the columns of nodes at 3/4 and at the end of the foot
    placed = FrictionMap.stripes([1.0, 0.2], width=1.0, start=0.875 * SIZE[0] - 1.0)
    ground = Plane(friction=0.5, friction_map=placed)
    view = seen(character, character.mesh.points.copy(), ground)
    left, right, foot = ground_patches(view, ("left", "right", "foot"))
    smooth = x > 0.875 * SIZE[0]
    assert left.friction == 0.5
    for patch in (right, foot):
        share = float(patch.weights[smooth].sum())
        assert 0.0 < share < 0.5
        assert np.isclose(patch.friction, 0.5 * (1.0 - 0.8 * share), rtol=1e-12)
    # the outer column has half of the area of one further in: 1/8 of the foot, 1/4 of its half
    np.testing.assert_allclose(foot.weights[smooth].sum(), 0.125, rtol=1e-9)
    np.testing.assert_allclose(right.weights[smooth].sum(), 0.25, rtol=1e-9)


def test_native_patches_have_it_too() -> None:
    character = block(1)
    placed = FrictionMap(factors=np.array([[1.0, 0.5], [0.25, 2.0]]), spacing=(0.2, 0.15))
    view = seen(character, character.mesh.points.copy(), Plane(friction_map=placed))
    native = replace(view)
    object.__setattr__(native, "workroom", {})
    regions = ("left", "right", "foot")
    found, expected = (ground_patches(own, regions) for own in (native, view))
    for one, other in zip(found, expected, strict=True):
        assert np.isclose(one.friction, other.friction, rtol=1e-12)
        assert one.friction not in (0.8, other.gap)
