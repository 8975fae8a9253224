"""Slopes and hills for scenes in which a body goes along x, by settings of theirs."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.scenes.plan import Setting, Values
from warp_softbody.world.ground import Ground, Plane
from warp_softbody.world.height_field import HeightField

GROUND_SETTINGS = (
    Setting(
        name="slope",
        default=0.0,
        low=-30.0,
        high=30.0,
        unit="degrees",
        help="how steeply the ground rises ahead",
    ),
    Setting(
        name="roughness",
        default=0.0,
        low=0.0,
        high=0.3,
        unit="body lengths",
        help="from the deepest valley to the highest hill ahead",
    ),
    Setting(name="ground_seed", default=0.0, low=0.0, high=1e6, help="which hills", whole=True),
)

SPACING = 0.05  # m, of the grid
BEGIN, EASE = 0.7, 0.6  # m, where the body's front and some room are behind, and hills set in
BACK, AHEAD, ASIDE = 1.5, 13.0, 2.5  # m, how far the grid goes
WAVES, SHORTEST, LONGEST = 40, 0.35, 1.2  # m, lengths of hills


def ground_ahead(values: Values) -> Ground:
    """A level place for a body of 1 m, and what the settings ask for ahead of it; or a plane."""
    if not is_uneven(values):
        return Plane(friction=values["friction"])
    x = np.arange(-BACK, AHEAD + 0.5 * SPACING, SPACING)
    y = np.arange(-ASIDE, ASIDE + 0.5 * SPACING, SPACING)
    share = np.clip((x - BEGIN) / EASE, 0.0, 1.0)
    # the integral of a slope that sets in evenly
    way = np.maximum(x - BEGIN - EASE, 0.0) + 0.5 * EASE * share**2
    rise = np.tan(np.radians(values["slope"])) * way
    hills = values["roughness"] * _hills(x, y, int(values["ground_seed"]))
    heights = rise[:, None] + (share * share * (3.0 - 2.0 * share))[:, None] * hills
    return HeightField(
        heights=heights,
        spacing=(SPACING, SPACING),
        origin=(-BACK, -ASIDE),
        friction=values["friction"],
    )


def is_uneven(values: Values) -> bool:
    """Whether the settings ask for more than a plane."""
    return bool(values["slope"] or values["roughness"])


def _hills(x: FloatArray, y: FloatArray, seed: int) -> FloatArray:
    """Waves of all directions and of like heights, from -1/2 to 1/2 in sum."""
    rng = np.random.default_rng(seed)
    lengths = np.exp(rng.uniform(np.log(SHORTEST), np.log(LONGEST), WAVES))
    angles, phases = rng.uniform(0.0, 2.0 * np.pi, (2, WAVES))
    numbers = 2.0 * np.pi / lengths
    along = np.multiply.outer(numbers * np.cos(angles), x)[:, :, None]
    across = np.multiply.outer(numbers * np.sin(angles), y)[:, None, :]
    total = np.sin(along + across + phases[:, None, None]).sum(axis=0)
    return np.asarray((total - 0.5 * (total.max() + total.min())) / np.ptp(total))
