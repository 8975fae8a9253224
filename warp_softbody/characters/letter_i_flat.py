"""The letter I, flattened and lying on the ground; the character that crawls."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from warp_softbody.character import Character
from warp_softbody.characters.fibers import STRENGTH_TO_BEND, group, ring
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.regions import EDGE, quadrants, select
from warp_softbody.characters.store import load_mesh
from warp_softbody.muscles import Fiber, FiberKind

THICKNESS = 0.16
KERNEL_WIDTH = 0.05
RECIPE = Recipe(
    name="letter_i_flat",
    outline=(
        (0.0, 0.0),
        (0.35, 0.0),
        (0.5, 0.0),
        (0.5, 0.25),
        (0.35, 0.25),
        (0.35, 0.15),
        (0.0, 0.15),
    ),
    depth=THICKNESS,
    size=0.082,
    lying=True,
)
BORDERS = (-0.5, -0.35, -0.175, 0.0, 0.175, 0.35, 0.5)
STRANDS = {
    "lower_right": (-1.0, -1.0),
    "lower_left": (1.0, -1.0),
    "upper_right": (-1.0, 1.0),
    "upper_left": (1.0, 1.0),
}


def letter_i_flat() -> Character:
    """Letter I lying along x, head at +x, with four longitudinal fibres and a radial one.

    It is 1 m long and 0.16 m thick, its bars 0.5 m and its stem 0.3 m across (y). Regions: the
    underside `belly` and its six parts from tail to head, `belly_0` (the bar of the tail) to
    `belly_5` (nodes between two parts belong to both); the bars `tail` and `head`; and the
    undersides of the bars' four ends beyond the stem, `corner_0` to `corner_3` (x and y: --, +-,
    -+, ++). Fibres: `longitudinal_lower_right` (y < 0), `_lower_left`, `_upper_right`,
    `_upper_left`, and `radial` around the middle.
    """
    mesh = load_mesh("letter_i_flat")
    x, y, z = mesh.points.T
    belly = z < EDGE
    masks = {"belly": belly, "tail": x < -0.35 + EDGE, "head": x > 0.35 - EDGE}
    for part, (start, end) in enumerate(pairwise(BORDERS)):
        masks[f"belly_{part}"] = belly & (x > start - EDGE) & (x < end + EDGE)
    masks |= quadrants("corner", mesh, belly & (abs(y) > 0.15 - EDGE) & (abs(x) > 0.35 - EDGE))
    strands = (_strand(name, *sides) for name, sides in STRANDS.items())
    middle = ring("radial", (0.0, 0.0, 0.5 * THICKNESS), (0.0, 0.11, 0.0), (0.0, 0.0, 0.055), 6)
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


def _strand(name: str, side: float, above: float) -> Fiber:
    x = np.linspace(-0.48, 0.48, 6)
    y, z = 0.11 * side, 0.5 * THICKNESS + 0.055 * above
    vertices = np.stack([x, np.full_like(x, y), np.full_like(x, z)], axis=1)
    return Fiber(vertices=vertices, kind=FiberKind.LONGITUDINAL, name=f"longitudinal_{name}")
