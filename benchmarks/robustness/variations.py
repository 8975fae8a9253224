"""Floors, bodies, meshes and steps for which the gains were not searched."""

from __future__ import annotations

from benchmarks.robustness.variation import Variation

EDGES = 1.06
"""Edges of the other meshes over those of the shipped ones: TetGen fills a new surface."""

VARIATIONS = {
    variation.name: variation
    for variation in (
        Variation(name="as shipped"),
        Variation(name="other mesh", edges=EDGES),
        Variation(name="friction -20 %", friction=0.8),
        Variation(name="friction +20 %", friction=1.2),
        Variation(name="stiffness -20 %", stiffness=0.8),
        Variation(name="stiffness +20 %", stiffness=1.2),
        Variation(name="half the step", time_step=0.5),
    )
}
