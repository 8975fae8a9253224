"""The letter O is a round ring; it is the character that rolls."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.character import Character
from warp_softbody.body.mesh import TetMesh
from warp_softbody.body.muscles import Fiber, FiberKind
from warp_softbody.characters.fibers import group
from warp_softbody.characters.recipe import Corners, Recipe
from warp_softbody.characters.regions import IntArray, select
from warp_softbody.characters.store import load_mesh

OUTER, INNER = 0.5, 0.28
LOOPS = {"outer": 0.45, "inner": 0.33}
SEGMENTS = 20


def ring_outline(outer: int, inner: int) -> Corners:
    """A quarter of the ring, its rim and its hole with so many sides each, m."""
    return _quarter_arc(OUTER, outer) + _quarter_arc(INNER, inner)[::-1]


def _quarter_arc(radius: float, sides: int) -> Corners:
    """Corners of a regular polygon from the x axis to the z axis, m."""
    quarter = np.linspace(0.0, np.pi / 2.0, sides + 1)
    arc = radius * np.stack([np.cos(quarter), np.sin(quarter)], axis=1)
    return tuple((float(x), float(z)) for x, z in arc.round(9))


RECIPE = Recipe(
    name="letter_o",
    outline=ring_outline(10, 6),
    depth=0.3,
    size=0.124,
    mirrors="xyz",
)


def letter_o(*, coarse: int = 0) -> Character:
    """Letter O, 1 m high on z = 0, with two concentric loops of fibres.

    The rim has 40 sides at a radius of 0.5 m, the hole 24 at 0.28 m; the ring is 0.3 m deep (y).
    Regions: the whole `rim`, and 20 parts of it, `rim-0` to `rim-19`, that follow one another from
    the lowest point by +x and over the top, each before one segment of either loop (nodes between
    two parts belong to both).
    """
    mesh = load_mesh("letter_o", coarse)
    loops = (_loop(f"loop_{name}", radius) for name, radius in LOOPS.items())
    return Character(
        name="letter_o", mesh=mesh, muscles=(group("loops", *loops),), regions=_rim(mesh)
    )


def _loop(name: str, radius: float) -> Fiber:
    """A closed fibre around the hole that starts below it and goes by +x."""
    angle = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1)
    vertices = radius * np.stack([np.sin(angle), np.zeros_like(angle), -np.cos(angle)], axis=1)
    return Fiber(
        vertices=vertices + np.array([0.0, 0.0, OUTER]), kind=FiberKind.LONGITUDINAL, name=name
    )


def _rim(mesh: TetMesh) -> dict[str, IntArray]:
    x, z = mesh.points[:, 0], mesh.points[:, 2] - OUTER
    # Between its corners a side comes nearer to the middle.
    rim = np.hypot(x, z) > OUTER * np.cos(np.pi / 40.0) - 1e-6
    turned = np.arctan2(x, -z) * SEGMENTS / (2.0 * np.pi)
    masks = {"rim": rim}
    for part in range(SEGMENTS):
        beyond = (turned - part - 0.5 + 0.5 * SEGMENTS) % SEGMENTS - 0.5 * SEGMENTS
        masks[f"rim-{part}"] = rim & (abs(beyond) < 0.5 + 1e-6)
    return select(masks)
