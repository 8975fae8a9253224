"""The letter X has four limbs bent down to its feet; it is the character that walks."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.muscles import Fiber, FiberKind
from warp_softbody.characters.fibers import QUADRANTS, STRENGTH_TO_BEND, group, ring
from warp_softbody.characters.recipe import Corners, Recipe
from warp_softbody.characters.regions import EDGE, quadrants, select
from warp_softbody.characters.store import load_mesh

HALF_WIDTH, THICKNESS = 0.1, 0.18
LENGTH = 0.6071
FOOT = 0.5
KERNEL_WIDTH = 0.06
STATIONS = (0.06, 0.195, 0.33, 0.465, 0.59)
RING_STATIONS = (0.24, 0.42)


def _corner(along: float, aside: float) -> tuple[float, float]:
    """Point x, y of the limb with x, y > 0: its distances along and aside of the limb's axis, m."""
    x, y = np.array([along - aside, along + aside]) * np.sqrt(0.5)
    return round(float(x), 9), round(float(y), 9)


NOTCH = round(HALF_WIDTH * float(np.sqrt(2.0)), 9)
OUTLINE: Corners = (
    (0.0, 0.0),
    (NOTCH, 0.0),
    _corner(LENGTH, -HALF_WIDTH),
    _corner(LENGTH, HALF_WIDTH),
    (0.0, NOTCH),
)
RECIPE = Recipe(
    name="letter_x",
    outline=OUTLINE,
    depth=THICKNESS,
    size=0.084,
    lying=True,
    arch=((0.15, 0.2), (FOOT, 0.0)),
)


def letter_x(*, coarse: int = 0) -> Character:
    """Letter X on four feet, 1 m long and wide, four longitudinal and two radial fibres a limb.

    Seen from above it is an X; its limbs, 0.2 m wide and 0.18 m thick, slope from the middle, 0.2 m
    above the ground, to the feet. Limbs and feet are counted by quadrant (x and y: --, +-, -+, ++).
    Regions: the undersides of all feet `base` and of each `foot_0` to `foot_3`, the `limb_0` to
    `limb_3` outside the middle, and the middle itself, `hub`, also called `head`.
    """
    mesh = load_mesh("letter_x", coarse)
    x, y, z = mesh.points.T
    along = (abs(x) + abs(y)) * np.sqrt(0.5)
    base, hub = z < EDGE, along < 0.15 + EDGE
    masks = {"base": base, "hub": hub, "head": hub}
    masks |= quadrants("foot", mesh, base) | quadrants("limb", mesh, ~hub)
    limbs = range(len(QUADRANTS))
    longitudinal = (_strand(limb, i) for limb in limbs for i in range(4))
    radial = (_ring(limb, i) for limb in limbs for i in range(2))
    muscles = (
        group("longitudinal", *longitudinal, strength=STRENGTH_TO_BEND, kernel_width=KERNEL_WIDTH),
        group("radial", *radial, strength=STRENGTH_TO_BEND),
    )
    return Character(
        name="letter_x",
        mesh=mesh,
        muscles=muscles,
        regions=select(masks),
    )


def _axes(limb: int) -> tuple[FloatArray, FloatArray]:
    """Unit vectors along and aside of a limb, such that limbs mirror each other."""
    x, y = QUADRANTS[limb]
    return np.array([x, y, 0.0]) * np.sqrt(0.5), np.array([-x, y, 0.0]) * np.sqrt(0.5)


def _strand(limb: int, index: int) -> Fiber:
    """A fibre along a limb, on one side of its middle: lower ones first, then upper ones."""
    along, aside = _axes(limb)
    side, above = QUADRANTS[index]
    stations = np.array(STATIONS)
    vertices = np.outer(stations, along) + 0.06 * side * aside
    vertices[:, 2] = RECIPE.lift(stations) + 0.5 * THICKNESS + 0.05 * above
    return Fiber(
        vertices=vertices, kind=FiberKind.LONGITUDINAL, name=f"longitudinal_{limb}_{index}"
    )


def _ring(limb: int, index: int) -> Fiber:
    along, aside = _axes(limb)
    station = RING_STATIONS[index]
    height = float(RECIPE.lift(station)) + 0.5 * THICKNESS
    x, y, _ = station * along
    u, v, _ = 0.07 * aside
    return ring(f"radial_{limb}_{index}", (x, y, height), (u, v, 0.0), (0.0, 0.0, 0.065), 6)
