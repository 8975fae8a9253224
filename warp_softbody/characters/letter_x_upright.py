"""The upright letter X stands on two of its limbs; it is the character that turns cartwheels."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind
from warp_softbody.characters.fibers import QUADRANTS, STRENGTH_TO_BEND, group, ring
from warp_softbody.characters.recipe import Recipe
from warp_softbody.characters.regions import EDGE, IntArray, select, standing
from warp_softbody.characters.store import load_mesh

HEIGHT, DEPTH = 1.0, 0.3
NOTCH = 0.16
FOOT = (0.17, 0.3)
"""m, from the middle: where a foot begins and ends, on each of the two sides that it touches."""
ANKLE = (0.4, 0.24)
KERNEL_WIDTH = 0.08
STATIONS = (0.08, 0.2, 0.32, 0.44, 0.55)
RING_STATIONS = (0.28, 0.43)
ASIDE, DEEP = 0.075, 0.1
"""m, of the fibres from the axis of their limb."""

RECIPE = Recipe(
    name="letter_x_upright",
    outline=(
        (0.0, 0.0),
        (NOTCH, 0.0),
        ANKLE,
        (0.5 * HEIGHT, FOOT[0]),
        (0.5 * HEIGHT, FOOT[1]),
        (FOOT[1], 0.5 * HEIGHT),
        (FOOT[0], 0.5 * HEIGHT),
        ANKLE[::-1],
        (0.0, NOTCH),
    ),
    depth=DEPTH,
    size=0.1,
    mirrors="xyz",
)


def letter_x_upright(*, coarse: int = 0) -> Character:
    """Letter X, 1 m high and wide on z = 0, upright on two limbs, alike after a quarter turn.

    Limbs and feet are counted around the middle, from the lower one at x > 0 by the upper one at
    x > 0: `limb_0` to `limb_3`, `foot_0` to `foot_3`. Each has four longitudinal and two radial
    fibres. Regions: besides these the quarters `foot_0_0` to `foot_3_3` of each foot (behind and
    ahead of its limb's middle, and y: --, +-, -+, ++), the whole `rim` of all feet, on which the
    letter turns, the underside `base` with its quadrants `base_patch_0` to `_3`, the upper feet
    `head`, and `hub`.
    """
    mesh = load_mesh("letter_x_upright", coarse)
    limbs = range(4)
    longitudinal = (_strand(limb, i) for limb in limbs for i in range(4))
    radial = (_ring(limb, i) for limb in limbs for i in range(2))
    muscles = (
        group("longitudinal", *longitudinal, strength=STRENGTH_TO_BEND, kernel_width=KERNEL_WIDTH),
        group("radial", *radial, strength=STRENGTH_TO_BEND),
    )
    return Character(name="letter_x_upright", mesh=mesh, muscles=muscles, regions=_regions(mesh))


def _axes(limb: int) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (3,) along and aside of a limb."""
    angle = np.pi * (0.5 * limb - 0.25)
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c, 0.0, s]), np.array([-s, 0.0, c])


def _strand(limb: int, index: int) -> Fiber:
    """A fibre along a limb, at one of the four edges of its middle."""
    along, aside = _axes(limb)
    side, deep = QUADRANTS[index]
    vertices = np.outer(STATIONS, along) + side * ASIDE * aside
    vertices += np.array([0.0, deep * DEEP, 0.5 * HEIGHT])
    return Fiber(
        vertices=vertices, kind=FiberKind.LONGITUDINAL, name=f"longitudinal_{limb}_{index}"
    )


def _ring(limb: int, index: int) -> Fiber:
    along, aside = _axes(limb)
    x, _, z = RING_STATIONS[index] * along
    u, _, w = ASIDE * aside
    centre = (float(x), 0.0, float(z) + 0.5 * HEIGHT)
    name = f"radial_{limb}_{index}"
    return ring(name, centre, (float(u), 0.0, float(w)), (0.0, DEEP, 0.0), 6)


def _regions(mesh: TetMesh) -> dict[str, IntArray]:
    x, z = mesh.points[:, 0], mesh.points[:, 2] - 0.5 * HEIGHT
    half = 0.5 * HEIGHT - EDGE
    # the two sides of the box around the letter and the end of the limb between them
    rim = (abs(x) > half) | (abs(z) > half) | (abs(x) + abs(z) > 0.5 * HEIGHT + FOOT[1] - EDGE)
    outside = abs(x) + abs(z) > np.sqrt(2.0) * STATIONS[1]
    masks = standing(mesh, head=0.9) | {"rim": rim, "hub": ~outside}
    for limb in range(4):
        along, aside = _axes(limb)
        own = (x * along[0] > 0.0) & (z * along[2] > 0.0)
        masks |= {f"foot_{limb}": rim & own, f"limb_{limb}": outside & own}
        beside = x * aside[0] + z * aside[2]
        for part, (side, deep) in enumerate(QUADRANTS):
            quarter = (side * beside > -EDGE) & (deep * mesh.points[:, 1] > -EDGE)
            masks[f"foot_{limb}_{part}"] = rim & own & quarter
    return select(masks)
