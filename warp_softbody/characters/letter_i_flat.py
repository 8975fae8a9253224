"""The flat letter I lies on the ground; it is the character that crawls."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.muscles import Fiber, FiberKind
from warp_softbody.characters.fibers import STRENGTH_TO_BEND, group, ring
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.regions import EDGE, quadrants, select
from warp_softbody.characters.store import load_mesh

THICKNESS = 0.1
KERNEL_WIDTH = 0.02
RECIPE = Recipe(
    name="letter_i_flat",
    outline=(
        (0.0, 0.0),
        (0.38, 0.0),
        (0.5, 0.0),
        (0.5, 0.2),
        (0.38, 0.2),
        (0.38, 0.1),
        (0.0, 0.1),
    ),
    depth=THICKNESS,
    size=0.066,
    lying=True,
)
BORDERS = (-0.5, -0.38, -0.19, 0.0, 0.19, 0.38, 0.5)
LOWER, UPPER = 0.01, 0.05
"""m, heights of the strands; the lower ones govern what lies below half way between, 0.03 m.

Muscles only pull, so whatever they contract gets shorter too; the thinner that part is, and the
further from the middle, the more they bend the body for it.
"""

STRANDS = {
    "lower_right": (-1.0, LOWER),
    "lower_left": (1.0, LOWER),
    "upper_right": (-1.0, UPPER),
    "upper_left": (1.0, UPPER),
}


def letter_i_flat(*, coarse: int = 0) -> Character:
    """Letter I lying along x, head at +x, with four longitudinal fibres and a radial one.

    It is 1 m long and 0.1 m thick, its bars 0.4 m and its stem 0.2 m across (y). Regions: the
    underside `belly` and its six parts from tail to head, `belly_0` (the bar of the tail) to
    `belly_5` (nodes between two parts belong to both); the bars `tail` and `head`; and the
    undersides of the bars' four ends beyond the stem, `corner_0` to `corner_3` (x and y: --, +-,
    -+, ++). Fibres: `longitudinal_lower_right` (y < 0), `_lower_left`, `_upper_right`,
    `_upper_left`, and `radial` around the middle.
    """
    mesh = load_mesh("letter_i_flat", coarse)
    x, y, z = mesh.points.T
    belly = z < EDGE
    masks = {"belly": belly, "tail": x < -0.38 + EDGE, "head": x > 0.38 - EDGE}
    for part, (start, end) in enumerate(pairwise(BORDERS)):
        masks[f"belly_{part}"] = belly & (x > start - EDGE) & (x < end + EDGE)
    masks |= quadrants("corner", mesh, belly & (abs(y) > 0.1 - EDGE) & (abs(x) > 0.38 - EDGE))
    strands = (_strand(name, *sides) for name, sides in STRANDS.items())
    middle = ring("radial", (0.0, 0.0, 0.5 * THICKNESS), (0.0, 0.07, 0.0), (0.0, 0.0, 0.03), 6)
    muscles = (
        group("longitudinal", *strands, strength=STRENGTH_TO_BEND, kernel_width=KERNEL_WIDTH),
        group("radial", middle, strength=STRENGTH_TO_BEND),
    )
    return Character(
        name="letter_i_flat",
        mesh=mesh,
        muscles=muscles,
        regions=select(masks),
    )


def _strand(name: str, side: float, height: float) -> Fiber:
    x = np.linspace(-0.48, 0.48, 6)
    vertices = np.stack([x, np.full_like(x, 0.07 * side), np.full_like(x, height)], axis=1)
    return Fiber(vertices=vertices, kind=FiberKind.LONGITUDINAL, name=f"longitudinal_{name}")
