"""Feet of a walking body as they are in a step, and what is asked of one that stands."""

from __future__ import annotations

import numpy as np

from warp_softbody.controllers.motions.body_measures import mean_weights
from warp_softbody.controllers.objectives import Objective
from warp_softbody.world.view import BodyView


class FeetNow:
    """Feet as they are in a step.

    Attributes:
        weights: (feet, n), nodal weights of their means.
        lowest: (feet, 3) m, their mean x and y, and z of their lowest nodes.
    """

    def __init__(self, view: BodyView, names: tuple[str, ...]) -> None:
        """Those regions of the character are its feet."""
        regions = [view.scene.character.region(name) for name in names]
        self.weights = np.array([mean_weights(view, (name,)) for name in names])
        self.lowest = self.weights @ view.positions
        self.lowest[:, 2] = [view.positions[nodes, 2].min() for nodes in regions]


def upward_only(objective: Objective) -> Objective:
    """The part of an objective on (x, y, z) that is about z."""
    z = slice(2, None)
    rows, target, weight = objective.rows[z], objective.target[z], objective.weight[z]
    return Objective(name="standing foot", rows=rows, target=target, weight=weight)
