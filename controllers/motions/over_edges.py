"""A body that lies is lifted over edges of the ground, node by node."""

from __future__ import annotations

import numpy as np

from warp_softbody.controllers import objectives
from warp_softbody.controllers.body_units import BodyUnits
from warp_softbody.controllers.motions.lying_on_terrain import LyingOnTerrain
from warp_softbody.controllers.objectives import Objective
from warp_softbody.world.view import BodyView

UPWARD, BACKWARD = 16.0, 4.0
"""Weights of their velocities, over the one given. Without the second, nodes that push against the
face of a step are pressed to it, and its friction keeps them down."""

NEARNESS = 3.0
"""Power of the nearness to an edge by which nodes count: those at it are caught first."""


def over_edges(
    view: BodyView,
    terrain: LyingOnTerrain,
    regions: tuple[str, ...],
    follow: float,
    weight: float,
) -> tuple[Objective, ...]:
    """That nodes of regions come over an edge before they go on; nothing where there is none.

    A node below the top of what it comes to touches its face and is held there: ground carries
    nodes, and what is between two of them hangs through an edge.

    Args:
        view: of the body.
        terrain: on which it lies.
        regions: of its underside.
        follow: 1/s, how fast nodes come up to the height that they lack.
        weight: of a velocity in units of sqrt(g L).
    """
    region = view.scene.character.region
    nodes = view.kept(
        ("nodes over edges", regions), lambda: np.unique(np.concatenate([*map(region, regions)]))
    )
    lacks, near = terrain.lacking(view.positions[nodes])
    shares = np.where(lacks > 0.0, near, 0.0) ** NEARNESS
    if not shares.any():
        return ()
    unit = 1.0 / BodyUnits.of(view).speed
    weights = np.zeros(view.node_count)
    weights[nodes] = shares / shares.sum()
    way = follow * float(weights[nodes] @ lacks)
    return (
        Objective(
            name="over an edge",
            rows=objectives.mean_rows(view, unit * weights)[[0, 2]],
            target=unit * np.array([-way, way]),
            weight=weight * np.array([BACKWARD, UPWARD]),
        ),
    )
