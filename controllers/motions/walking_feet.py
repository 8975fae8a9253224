"""Feet of a walking body as they are in a step, and what is asked of one that stands."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.controllers.motions.body_measures import mean_weights
from warp_softbody.controllers.objectives import Objective
from warp_softbody.world.view import BodyView


class FeetNow:
    """Feet as they are in a step.

    Attributes:
        weights: (feet, n), nodal weights of their means.
        lowest: (feet, 3) m, their mean x and y, and z of their lowest nodes.
        speeds: (feet, 3) m/s, mean velocities.
    """

    def __init__(self, view: BodyView, names: tuple[str, ...]) -> None:
        """Those regions of the character are its feet."""
        known: _Feet = view.kept(("feet", names), lambda: _feet(view, names))
        self.weights = known.weights
        self.speeds = known.weights @ view.velocities
        self.lowest = known.weights @ view.positions
        self.lowest[:, 2] = np.minimum.reduceat(view.positions[known.nodes, 2], known.begins)


class _Feet(NamedTuple):
    """Weights (feet, n) of the means, the nodes of one foot after the other, and their begins."""

    weights: FloatArray
    nodes: npt.NDArray[np.int32]
    begins: npt.NDArray[np.intp]


def _feet(view: BodyView, names: tuple[str, ...]) -> _Feet:
    regions = [view.scene.character.region(name) for name in names]
    counts = np.array([len(nodes) for nodes in regions])
    weights = np.array([mean_weights(view, (name,)) for name in names])
    return _Feet(weights, np.concatenate(regions), np.cumsum(counts) - counts)


def upward_only(objective: Objective) -> Objective:
    """The part of an objective on (x, y, z) that is about z."""
    z = slice(2, None)
    rows, target, weight = objective.rows[z], objective.target[z], objective.weight[z]
    return Objective(name="standing foot", rows=rows, target=target, weight=weight)
