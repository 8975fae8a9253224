"""The catalogue of the stability suite, row by row of its table."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from benchmarks.stability import bodies, starts
from benchmarks.stability.cases import StabilityCase, StabilityGoal, release
from benchmarks.stability.movers import CaseSetup
from warp_softbody import Character, Plane

Make = Callable[[], Character]

AXES = (0, 1, 2)
SEEDS = range(12)
TURNED = range(3)
KINKS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, 1.0))
"""Axes of half turns."""

PULL = 2.0
"""Time for which muscles pull, s."""

TURNS = 10.0
GRAVITY = 9.81
SLOPE = 0.2
"""Inclination of the slope, rad; its friction coefficient, 0.5, holds up to 0.46."""

REST_STEPS = 100_000


def bar(damped: bool = True, clamped: bool = True, **material: float) -> Make:
    """Maker of the bar of 0.6 x 0.2 x 0.2 m and 144 tets."""
    return lambda: bodies.body(bodies.bar_mesh(), damped=damped, clamped=clamped, **material)


def cube(damped: bool = True) -> Make:
    """Maker of a free cube of 0.2 m and 48 tets."""
    return lambda: bodies.body(bodies.bar_mesh((2, 2, 2)), damped=damped, clamped=False)


def power(value: float) -> str:
    """A power of ten without zeros that say nothing."""
    return f"{value:.0e}".replace("e+0", "e").replace("e-0", "e-")


def time_steps() -> list[StabilityCase]:
    """A bent bar over four decades of the time step."""
    cases = []
    for dt in (1e-4, 1e-3, 1e-2, 0.1, 0.5):
        text = f"dt = {dt:g} s, bent bar"
        long = dt < 1e-3
        cases.append(release(f"dt {dt:g}", text, bar(), starts.bent, time_step=dt, long=long))
    for dt in (1e-3, 1e-2, 0.1, 0.5):
        text, make = f"dt = {dt:g} s, bent bar, no damping", bar(damped=False)
        cases.append(release(f"dt {dt:g} undamped", text, make, starts.bent, time_step=dt))
    return cases


def materials() -> list[StabilityCase]:
    """A bent bar of extreme materials."""
    cases = []
    for nu in (0.0, 0.3, 0.45, 0.49, 0.499):
        make = bar(poisson_ratio=nu)
        cases.append(release(f"nu {nu:g}", f"nu = {nu:g}, bent bar", make, starts.bent))
    for modulus in (1e3, 1e5, 1e7, 1e9):
        name, make = f"E {power(modulus)}", bar(young_modulus=modulus)
        text = f"E = {power(modulus)} Pa, bent bar"
        cases.append(release(name, text, make, starts.bent))
    for density in (1.0, 1e5):
        make, text = bar(density=density), f"density {density:g} kg/m^3, bent bar"
        cases.append(release(f"density {density:g}", text, make, starts.bent))
    return cases


def releases() -> list[StabilityCase]:
    """Bodies far from their rest shape."""
    triple, point = starts.stretched(3.0), starts.collapsed
    flat = [starts.flattened(axis) for axis in AXES]
    beam, clamped, free = bodies.beam, bar(), bar(clamped=False)
    undamped, loose = bar(damped=False), bar(damped=False, clamped=False)
    return [
        release("stretched", "released at 3 times its length, beam", beam, triple),
        release("stretched undamped", "the same, bar, no damping", undamped, triple),
        release("stretched free", "the same, free bar", free, triple),
        release("flat", "squashed to a plane (across x, y, z), bar", clamped, *flat),
        release("flat undamped", "the same, no damping", undamped, *flat),
        release("flat free", "the same, free bar", free, *flat),
        release("point", "all points at one point, beam", beam, point),
        release("point undamped", "the same, bar, no damping", undamped, point),
        release("point free", "the same, free bar", free, point),
        *inside_out(beam, clamped, undamped, free, loose),
    ]


def inside_out(
    beam: Make, clamped: Make, undamped: Make, free: Make, loose: Make
) -> list[StabilityCase]:
    """Bodies with inverted tets.

    What such a body does depends on the last digit, so each is released from several starts; a free
    one also turned, which changes nothing but digits.
    """
    mirrors = [starts.mirrored(axis) for axis in AXES]
    turned = [starts.turned(mirror, seed) for seed in TURNED for mirror in mirrors]
    random = [starts.scattered(seed) for seed in SEEDS]
    thrown = partial(release, inside_out=True)
    patient, scattered = partial(thrown, patience=4), partial(thrown, patience=8, long=True)
    kinks = [starts.kinked(axis) for axis in KINKS]
    return [
        thrown("mirrored", "mirrored inside out (across x, y, z), beam", beam, *mirrors),
        thrown("mirrored undamped", "the same, bar, no damping", undamped, *mirrors),
        patient("mirrored free", "the same, free bar, turned", free, *turned),
        patient("mirrored free undamped", "the same, no damping", loose, *turned),
        scattered("random", "random points in a box 10 times the bar's", clamped, *random),
        scattered("random free", "the same, free bar", free, *random, long=True),
        scattered("random beam", "the same, beam", beam, *random, long=True),
        scattered(
            "kinked", "one layer of cells turned half about x, y, z, yz, xyz", clamped, *kinks
        ),
    ]


def meshes() -> list[StabilityCase]:
    """Poor tets, in a body released bent and at three times its length."""
    begins = (starts.bent, starts.stretched(3.0))
    slivers: Make = lambda: bodies.body(bodies.sliver_mesh(0.1))  # noqa: E731
    tiny: Make = lambda: bodies.body(bodies.tiny_tet_mesh())  # noqa: E731
    return [
        release("slivers", "slivers of 0.1 degrees, bent and stretched bar", slivers, *begins),
        release("tiny tet", "a tet 1e-6 of the others' volume, the same", tiny, *begins),
    ]


def muscles() -> list[StabilityCase]:
    """Slack to full in one step, a pull, and back to slack in one step."""

    def case(name: str, text: str, make: Make, time_step: float) -> StabilityCase:
        let_go = release(name, text, make, starts.at_rest, time_step=time_step)
        pulled = max(20, round(PULL / time_step))
        steps = pulled + let_go.setting.steps
        setting = replace(let_go.setting, pulled=pulled, steps=steps)
        return replace(let_go, setting=setting, forced=True)

    even, strong = partial(bodies.muscular_bar, 2e5), partial(bodies.muscular_bar, 2e6)
    loose = partial(bodies.muscular_bar, 2e6, damped=False)
    return [
        case("muscles", "muscles slack, full and slack, letter I", bodies.letter, 0.01),
        case("muscles dt 0.5", "the same, dt = 0.5 s", bodies.letter, 0.5),
        case("muscles bar", "the same, free bar, strength = E", even, 0.01),
        case("muscles strong", "the same, free bar, strength = 10 E", strong, 0.01),
        case("muscles strong undamped", "the same, no damping", loose, 0.01),
    ]


def turning() -> list[StabilityCase]:
    """A free cube that turns ten times."""

    def case(name: str, text: str, make: Make, time_step: float, speed: float) -> StabilityCase:
        setting = CaseSetup(
            make=make,
            starts=(starts.spinning(speed),),
            time_step=time_step,
            steps=round(TURNS * 2.0 * math.pi / (speed * time_step)),
        )
        return StabilityCase(name=name, extreme=text, goal=StabilityGoal.TURN, setting=setting)

    fast, loose = 2.0 * math.pi * 10.0, cube(damped=False)
    return [
        case("spin", "10 turns a second, free cube, no damping", loose, 0.01, fast),
        case("spin damped", "the same, damped", cube(), 0.01, fast),
        case("spin dt 0.001", "the same, no damping, dt = 0.001 s", loose, 0.001, fast),
        case("turn dt 0.5", "0.1 rad/s, free cube, no damping, dt = 0.5 s", loose, 0.5, 0.1),
    ]


def resting() -> list[StabilityCase]:
    """100,000 steps in which nothing should happen."""
    down, ground = (0.0, 0.0, -GRAVITY), Plane(friction=0.5)
    tilted = (GRAVITY * math.sin(SLOPE), 0.0, -GRAVITY * math.cos(SLOPE))
    free = CaseSetup(make=cube(), starts=(starts.at_rest,), time_step=0.01, steps=REST_STEPS)
    standing = replace(free, ground=ground, gravity=down)

    def case(name: str, text: str, setting: CaseSetup) -> StabilityCase:
        return StabilityCase(
            name=name, extreme=text, goal=StabilityGoal.STAY, setting=setting, long=True
        )

    loose = replace(free, make=cube(damped=False))
    return [
        case("rest", "100,000 steps of rest, free cube", free),
        case("rest undamped", "the same, no damping", loose),
        case(
            "rest hanging",
            "the same, bar under its weight",
            replace(free, make=bar(), gravity=down),
        ),
        case("rest standing", "the same, cube on the ground", standing),
        case("rest on a slope", "the same, slope of 0.2 rad", replace(standing, gravity=tilted)),
    ]


CASES: tuple[StabilityCase, ...] = (
    *time_steps(),
    *materials(),
    *releases(),
    *meshes(),
    *muscles(),
    *turning(),
    *resting(),
)
