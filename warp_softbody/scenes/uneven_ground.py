"""Slopes, hills, steps and smooth stripes for scenes in which a body goes along x, by settings."""

from __future__ import annotations

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.scenes.plan import Setting, Values
from warp_softbody.world.friction_map import FrictionMap
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
    Setting(
        name="steps",
        default=0.0,
        low=0.0,
        high=0.2,
        unit="body lengths",
        help="height of steps up and down across the way",
    ),
    Setting(
        name="friction_stripes",
        default=0.0,
        low=0.0,
        high=0.95,
        help="share of the friction that stripes across the way may lack",
    ),
    Setting(
        name="ground_seed",
        default=0.0,
        low=0.0,
        high=1e6,
        help="which hills, steps and stripes",
        whole=True,
    ),
)

SPACING = 0.05  # m, of the grid
BEGIN, EASE = 0.7, 0.6  # m, where the body's front and some room are behind, and hills set in
BACK, AHEAD, ASIDE = 1.5, 13.0, 2.5  # m, how far the grid goes
WAVES, SHORTEST, LONGEST = 40, 0.35, 1.2  # m, lengths of hills
RISER = 0.0125  # m, along the way: as steep as a grid of heights has it
TREAD = (0.4, 1.0)  # m, from one step to the next
MOST_UP = 2  # steps above and below where the way begins
STRIPE = 0.5  # m


def ground_ahead(values: Values) -> Ground:
    """A level place for a body of 1 m, and what the settings ask for ahead of it; or a plane."""
    friction, placed = values["friction"], _stripes(values)
    if not is_uneven(values):
        return Plane(friction=friction, friction_map=placed)
    along = RISER if values["steps"] else SPACING
    x = np.arange(-BACK, AHEAD + 0.5 * along, along)
    # steps are straight across, so that without hills three columns do
    across = SPACING if values["roughness"] else ASIDE
    y = np.arange(-ASIDE, ASIDE + 0.5 * across, across)
    share = np.clip((x - BEGIN) / EASE, 0.0, 1.0)
    # the integral of a slope that sets in evenly
    way = np.maximum(x - BEGIN - EASE, 0.0) + 0.5 * EASE * share**2
    rise = np.tan(np.radians(values["slope"])) * way
    seed = int(values["ground_seed"])
    heights = np.repeat(rise[:, None], len(y), axis=1)
    if values["roughness"]:
        hills = values["roughness"] * _hills(x, y, seed)
        heights = heights + (share * share * (3.0 - 2.0 * share))[:, None] * hills
    if values["steps"]:
        heights = heights + values["steps"] * _stairs(x, seed)[:, None]
    return HeightField(
        heights=heights,
        spacing=(along, across),
        origin=(-BACK, -ASIDE),
        friction=friction,
        friction_map=placed,
    )


def is_uneven(values: Values) -> bool:
    """Whether the settings ask for more than a plane."""
    return bool(values["slope"] or values["roughness"] or values["steps"])


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


def _stairs(x: FloatArray, seed: int) -> FloatArray:
    """How many steps up it is at places x, m: up and down in any order, the first one up."""
    rng = np.random.default_rng((seed, 1))
    treads = rng.uniform(*TREAD, int(AHEAD / TREAD[0]) + 1)
    places = BEGIN + 0.5 * EASE + np.cumsum(treads) - treads[0]
    found, level = np.zeros_like(x), 0
    for number, place in enumerate(places):
        up = 1 if number == 0 or rng.random() < 0.5 else -1
        up = -up if abs(level + up) > MOST_UP else up
        level += up
        # from the last place before it to the next one of the grid
        found += up * (x > place)
    return found


def _stripes(values: Values) -> FrictionMap | None:
    """Stripes ahead that lack some of the friction; None where none are asked for."""
    most = values["friction_stripes"]
    if not most:
        return None
    rng = np.random.default_rng((int(values["ground_seed"]), 2))
    factors = 1.0 - most * rng.random(int(AHEAD / STRIPE))
    # what is before the first one is the level place
    return FrictionMap.stripes([1.0, *factors.tolist()], width=STRIPE, start=BEGIN - STRIPE)
