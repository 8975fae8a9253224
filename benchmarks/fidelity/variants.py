"""The ways in which a motion's physics is computed otherwise, one line each.

Another one is a line more here: any option of the engine, a mesh, a step, a turn of the world
(`Variation` has them all).
"""

from __future__ import annotations

from benchmarks.robustness.variation import Variation

COARSER = 1.3
"""Edges of the coarser meshes over those of the shipped ones."""

TURN = 37.0
"""Degrees by which the world is turned: no multiple of the 45 between a polygon's directions."""

VARIANTS = {
    variant.name: variant
    for variant in (
        Variation(name="as shipped"),
        Variation(name="dt x 2", time_step=2.0),
        Variation(name="dt / 2", time_step=0.5),
        Variation(name="dt / 4", time_step=0.25),
        Variation(name="two iterations", options={"newton_iterations": 2}),
        Variation(name="two iterations, dt / 2", time_step=0.5, options={"newton_iterations": 2}),
        Variation(name="warped tangent", options={"tangent": "warped"}),
        Variation(name="linear elements", options={"elements": "linear"}),
        Variation(name="coarser mesh", edges=COARSER),
        Variation(name="refined mesh", levels=1),
        Variation(name="refined mesh, dt / 2", levels=1, time_step=0.5),
        Variation(name="turned world", turn=TURN),
    )
}

COMPARED = ("as shipped", "dt / 2", "two iterations", "warped tangent", "refined mesh")
"""Variants of the same physics, the shipped one first: between them the number of a motion that is
known does not move."""
