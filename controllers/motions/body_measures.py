"""What the motions measure on a body: means of its regions, and by how much it has turned."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.contact_quadrature import measure, shares_of
from warp_softbody.world.ground import Plane
from warp_softbody.world.view import BodyView

BASE_PATCHES = ("base_patch_0", "base_patch_1", "base_patch_2", "base_patch_3")
"""The quadrants of a letter's underside."""


def region_mean(view: BodyView, values: FloatArray, region: str) -> FloatArray:
    """The mean (3,) of nodal values (n, 3) over a named region of the character."""
    return np.asarray(values[view.scene.character.region(region)].mean(axis=0))


def contact_point(view: BodyView, region: str) -> FloatArray:
    """Where (3,) m a region of the character's surface touches, or comes nearest to, the ground."""
    nodes = view.scene.character.region(region)
    shares, _ = shares_of(view, measure(view, view.scene.ground or Plane(), nodes))
    return np.asarray(shares @ view.positions[nodes])


def mean_weights(view: BodyView, regions: tuple[str, ...]) -> FloatArray:
    """Nodal weights (n,) of the mean over the union of some regions; their sum is one."""
    weights = np.zeros(view.node_count)
    for name in regions:
        weights[view.scene.character.region(name)] = 1.0
    weights /= weights.sum()
    return weights


def angle_turned(view: BodyView, first: int, second: int) -> float:
    """Angle (rad) from axis ``first`` towards axis ``second`` by which the body has turned.

    It is that of the rotation in the plane of these two axes (0, 1 or 2) that brings the rest shape
    nearest to the present one, nodes weighted by their masses.
    """
    rest = view.scene.character.mesh.points
    arms = (rest - view.masses @ rest / view.mass) * view.masses[:, None]
    moments = arms.T @ (view.positions - view.center_of_mass)
    turned = moments[first, second] - moments[second, first]
    return float(np.arctan2(turned, moments[first, first] + moments[second, second]))
