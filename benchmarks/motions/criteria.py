"""What each motion must show, as numbers of its stage and their bounds.

The first criterion of a scene is its own number, by which the table of robustness shows it. Lengths
are in m for bodies 1 m high or long.
"""

from __future__ import annotations

import numpy as np

from benchmarks.motions import measures as of
from benchmarks.motions.criterion import Criterion, Finding, RecordedMotion, below
from warp_softbody.accuracy.cases import body_motion
from warp_softbody.arrays import FloatArray
from warp_softbody.controllers import Trail
from warp_softbody.scenes.walk_x import figure_of_eight
from warp_softbody.stage_exports import reversals

PER_CENT, DEGREES, SECONDS, SPEED = "{:.1%}", "{:.0f} degrees", "{:.2f} s", "{:.2f} m/s"

SOUND = (
    below("not finite", lambda m: float((~m.measures.finite).sum()), 0.5, "{:.0f} frames"),
    Criterion("smallest tet", lambda m: float(m.measures.smallest_volume_ratio.min()), 1e-9),
    below("volume", lambda m: float(np.abs(m.measures.volume_change).max()), 0.05, PER_CENT),
    below("depth", lambda m: 1e3 * float(m.measures.penetration.max()), 2.0, "{:.1f} mm"),
    below("reversals", lambda m: reversals(m.take), 0.15, PER_CENT),
)

TILT = below("tilt at the end", lambda m: float(m.measures.tilt[-1]), 5.0, DEGREES)
STILL = below("speed at the end", lambda m: float(of.speed(m.take, m.measures)[-1]), 0.1, SPEED)
UPRIGHT = (
    TILT,
    STILL,
    Criterion("height", lambda m: float(of.height(m.measures)[-1]), 0.9, form="{:.2f}"),
)
AIR = Criterion("in the air", lambda m: max(of.flights(m.take), default=0.0), 0.2, form=SECONDS)

SWAY, PERIOD, PERIODS, SWAY_START = 0.09, 2.0, 4.0, 0.5  # m, s, number, s


def sway_error(motion: RecordedMotion) -> float:
    """Largest distance from the sine along x after the first period, over the amplitude."""
    time = motion.measures.times - SWAY_START
    moved = motion.measures.centre_of_mass[:, 0] - motion.measures.centre_of_mass[0, 0]
    steady = (time >= PERIOD) & (time <= PERIOD * PERIODS)
    wanted = SWAY * np.sin(2.0 * np.pi * time / PERIOD)
    return float(np.abs(moved - wanted)[steady].max(initial=0.0) / SWAY)


def squash(motion: RecordedMotion) -> float:
    """How much the length of a leg, foot to top, varies; the lesser of both, m."""
    take, legs = motion.take, (-1.0, 1.0)
    ranges = []
    for side in legs:
        leg = side * take.rest[:, 0] > 0.1
        foot, top = leg & of.base(take), leg & (take.rest[:, 2] > 1.0 - body_motion.LOWEST)
        way = take.tet_points[:, top].mean(axis=1) - take.tet_points[:, foot].mean(axis=1)
        ranges.append(float(np.ptp(np.linalg.norm(way, axis=1))))
    return min(ranges)


BALANCED = 3.7  # s, three after the end of the push


def after(motion: RecordedMotion, series: FloatArray, time: float) -> float:
    """Largest number of a series from a time on; infinite where the run ends before."""
    values = series[motion.measures.times > time - 1e-6]
    return float(values.max()) if len(values) else np.inf


def base_growth(motion: RecordedMotion) -> float:
    """Largest growth of the base's area, as a share."""
    area = motion.measures.base_area
    return float(area.max() / area[0] - 1.0)


BALANCE = (
    below("tilt 3 s later", lambda m: after(m, m.measures.tilt, BALANCED), 5.0, DEGREES),
    below("speed", lambda m: after(m, of.speed(m.take, m.measures), BALANCED), 0.1, SPEED),
    Criterion("lowest", lambda m: float(of.height(m.measures).min()), 0.5, form="{:.2f}"),
    Criterion("base growth", base_growth, 0.05, form=PER_CENT),
    Criterion("base lifted", lambda m: of.lifted(m.take), 0.1, form="{:.0%}"),
)

PULLED = (2.5, 3.5)  # s, around the strongest pull
F_HEAD = 0.88  # m


def went(motion: RecordedMotion) -> float:
    """Way of the centre of mass along x, m."""
    path = motion.measures.centre_of_mass[:, 0]
    return float(path[-1] - path[0])


def slid(motion: RecordedMotion, side: float) -> float:
    """Way of the base along the pull, m."""
    path = of.base_path(motion.take)
    return side * float(path[-1, 0] - path[0, 0])


def lean(motion: RecordedMotion, side: float) -> float:
    """Mean lean away from the pull while it is strongest, degrees."""
    time = motion.measures.times
    pulled = (time > PULLED[0]) & (time < PULLED[1])
    return -side * float(of.leaning(motion.take, F_HEAD)[pulled].mean())


def sliding(side: float) -> tuple[Criterion, ...]:
    """Slide towards a side, leaning against the pull, and do not topple."""
    return (
        Criterion("slides", lambda m: slid(m, side), 1.0),
        Criterion("lean", lambda m: lean(m, side), 2.0, form=DEGREES),
        below("largest tilt", lambda m: float(m.measures.tilt.max()), 30.0, DEGREES),
        Criterion("lowest", lambda m: float(of.height(m.measures).min()), 0.75, form="{:.2f}"),
    )


def jumps(motion: RecordedMotion) -> float:
    """Flights of at least 0.15 s."""
    return float(sum(length >= 0.15 - 1e-9 for length in of.flights(motion.take)))


ROLLED = Criterion("rolls", lambda m: float(of.turned(m.take, 1).max()), 360.0, form=DEGREES)
ASIDE = below("aside", lambda m: float(np.abs(m.measures.centre_of_mass[:, 1]).max()), 0.1)
CORNERS = ("corner_0", "corner_1", "corner_2", "corner_3")
CRAWL_START, CYCLE = 0.5, 1.2  # s


def ways(motion: RecordedMotion) -> list[FloatArray]:
    """Ways along x of the centre of mass and of the four corners of a crawler, (f,) m each."""
    corners = (of.region_path(motion.take, motion.character, name) for name in CORNERS)
    return [path[:, 0] for path in (motion.measures.centre_of_mass, *corners)]


def arches(motion: RecordedMotion) -> list[float]:
    """Height in m that the lowest node of the belly's middle reaches in each cycle."""
    cycle = np.floor((motion.take.times - CRAWL_START) / CYCLE + 1e-6)
    middle = of.belly_middle(motion.take)
    return [float(middle[cycle == k].max()) for k in range(int(cycle.max()))]


def belly(motion: RecordedMotion) -> float:
    """Greatest height of a point of the belly, m."""
    return float(motion.take.tet_points[:, of.base(motion.take), 2].max())


CRAWL = (
    Criterion("ahead", lambda m: min(float(way[-1] - way[0]) for way in ways(m)), 1.0),
    below("slip", lambda m: max(of.slip(way) for way in ways(m)), 0.1, "{:.0%}"),
    ASIDE,
)

FEET = ("foot_0", "foot_1", "foot_2", "foot_3")
EIGHT, LOOK = 0.6, 0.3  # m, radius, and how far ahead the nearest point of a trail is looked for
LIFTED = 0.0076  # m, 2 % of the height of the X


def feet(motion: RecordedMotion) -> FloatArray:
    """Height of the lowest node of each foot, (f, 4) m."""
    return of.lowest_of_regions(motion.take, motion.character, FEET)


def fewest_lifts(motion: RecordedMotion) -> float:
    """How often the foot was lifted clear that was so least often."""
    return float(min(len(of.lifts(foot, LIFTED)) for foot in feet(motion).T))


def walking(at_once: int) -> tuple[Criterion, ...]:
    """Go a body length on feet that are lifted clear, so many at once, without falling."""
    return (
        Criterion("ahead", went, 1.0),
        Criterion("lifts of a foot", fewest_lifts, 2.5, form="{:.0f}"),
        below(
            "feet up at once",
            lambda m: float((feet(m) > LIFTED).sum(axis=1).max()),
            at_once + 0.5,
            "{:.0f}",
        ),
        below("largest tilt", lambda m: float(m.measures.tilt.max()), 15.0, DEGREES),
        Criterion(
            "middle",
            lambda m: float(m.take.tet_points[:, m.character.region("hub"), 2].min()),
            0.05,
        ),
    )


def on_trail(motion: RecordedMotion) -> FloatArray:
    """Way along the figure of eight and distance of the centre of mass from it, (f, 2) m."""
    trail = Trail(points=figure_of_eight(EIGHT))
    found, arc = [], 0.0
    for place in motion.measures.centre_of_mass[:, :2]:
        arc = trail.nearest(place, arc, arc + 2.0 * LOOK)
        found.append((arc, float(np.hypot(*(trail.point(arc) - place)))))
    return np.array(found)


LIMBS = tuple(f"foot_{limb}" for limb in range(4))


def stood_on(motion: RecordedMotion) -> float:
    """How many limbs alone carried the body for a frame at least."""
    down = of.lowest_of_regions(motion.take, motion.character, LIMBS) < body_motion.CLEAR
    return float(down[down.sum(axis=1) == 1].any(axis=0).sum())


CRITERIA: dict[str, tuple[Criterion, ...]] = {
    "exercise-h": (
        below("error", sway_error, 0.1, PER_CENT),
        Criterion("squash", squash, 0.05),
    ),
    "balance-i": BALANCE,
    "slide-f": sliding(1.0),
    "slide-f-left": sliding(-1.0),
    "slide-f-delayed": sliding(1.0),
    "jump-i": (
        Criterion("ahead", lambda m: slid(m, 1.0), 0.25),
        AIR,
        *UPRIGHT,
    ),
    "jump-i-in-place": (
        Criterion("jumps", jumps, 3.0, form="{:.0f} jumps"),
        *UPRIGHT,
    ),
    "leap-i": (
        Criterion("leap", lambda m: max(of.leaps(m.take), default=0.0), 0.2),
        below("aside", ASIDE.of, 0.1),
        *UPRIGHT,
    ),
    "jump-t": (
        Criterion("turns in the air", lambda m: of.turned_in_air(m.take), 45.0, form=DEGREES),
        *UPRIGHT,
    ),
    "roll-o": (
        ROLLED,
        STILL,
        ASIDE,
    ),
    "roll-o-return": (
        Criterion("rolls back", lambda m: of.rolled_back(m.take), 180.0, form=DEGREES),
        Criterion("rolls", ROLLED.of, 180.0, form=DEGREES),
        STILL,
        ASIDE,
    ),
    "flip-i": (
        Criterion("turns in the air", lambda m: of.flipped_in_air(m.take), 300.0, form=DEGREES),
        *UPRIGHT,
    ),
    "cartwheel-x": (
        Criterion("turns", lambda m: float(of.turned(m.take, 1)[-1]), 355.0, form=DEGREES),
        Criterion("limbs stood on", stood_on, 4.0, form="{:.0f}"),
        *UPRIGHT,
        below("aside", ASIDE.of, 0.3),
    ),
    "crawl-i": (*CRAWL, below("belly", belly, 0.15)),
    "crawl-i-inchworm": (*CRAWL, Criterion("arch", lambda m: min(arches(m)), 0.2)),
    "walk-x": walking(1),
    "walk-x-fast": walking(2),
    "walk-x-eight": (
        Criterion("way", lambda m: float(on_trail(m)[-1, 0]), 7.2),
        below("off the trail", lambda m: float(on_trail(m)[:, 1].max()), 0.15, form="{:.3f} m"),
        below("end", lambda m: float(of.speed(m.take, m.measures)[-1]), 0.5, SPEED),
        *walking(2)[2:],
    ),
}


def examine(scene: str, motion: RecordedMotion) -> list[Finding]:
    """Every number that is asked of a scene, its own first."""
    return [Finding(criterion, criterion.of(motion)) for criterion in (*CRITERIA[scene], *SOUND)]
