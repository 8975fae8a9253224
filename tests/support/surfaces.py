"""Surfaces of bodies that nobody prepared for this package, m, z up: most of several parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import trimesh
from trimesh import creation

Point = tuple[float, float, float]


def joined(*parts: Any) -> Any:
    """One surface of several that may cross each other."""
    return trimesh.util.concatenate(parts)


def at(part: Any, place: Point) -> Any:
    """A part with its middle at a place."""
    moved = part.copy()
    moved.apply_translation(np.array(place) - moved.bounds.mean(axis=0))
    return moved


def limb(start: Point, end: Point, radius: float) -> Any:
    """A capsule from one point to another."""
    way = np.subtract(end, start)
    height = float(np.linalg.norm(way))
    part = at(creation.capsule(height=height, radius=radius, count=[12, 12]), (0.0, 0.0, 0.0))
    turn: Any = trimesh.geometry.align_vectors  # its types are not told
    part.apply_transform(turn([0.0, 0.0, 1.0], way / height))
    part.apply_translation(np.add(start, end) / 2.0)
    return part


def capsule() -> Any:
    """A standing capsule."""
    return creation.capsule(height=0.6, radius=0.2)


def letter_y() -> Any:
    """A stem on a flat foot, with two arms."""
    return joined(
        at(creation.box((0.5, 0.4, 0.1)), (0.0, 0.0, 0.05)),
        limb((0.0, 0.0, 0.2), (0.0, 0.0, 0.6), 0.13),
        *(limb((0.0, 0.0, 0.6), (x, 0.0, 1.0), 0.1) for x in (-0.3, 0.3)),
    )


def table() -> Any:
    """A board on four legs."""
    legs = [(x, y, 0.3) for x in (-0.4, 0.4) for y in (-0.25, 0.25)]
    board = at(creation.box((1.0, 0.7, 0.12)), (0.0, 0.0, 0.62))
    return joined(board, *(at(creation.box((0.14, 0.14, 0.6)), place) for place in legs))


def starfish() -> Any:
    """Five arms around a disc, lying."""
    turns = 2.0 * np.pi * np.arange(5) / 5.0
    ways = [(float(np.cos(turn)), float(np.sin(turn))) for turn in turns]
    arms = (limb((0.1 * x, 0.1 * y, 0.08), (0.6 * x, 0.6 * y, 0.08), 0.08) for x, y in ways)
    return joined(at(creation.cylinder(0.22, 0.16), (0.0, 0.0, 0.08)), *arms)


def quadruped() -> Any:
    """A trunk with a head on four legs."""
    places = [(x, y) for x in (-0.35, 0.35) for y in (-0.12, 0.12)]
    return joined(
        limb((-0.4, 0.0, 0.5), (0.4, 0.0, 0.5), 0.16),
        limb((0.4, 0.0, 0.5), (0.6, 0.0, 0.75), 0.1),
        *(limb((x, y, 0.5), (x, y, 0.08), 0.08) for x, y in places),
    )


def caterpillar() -> Any:
    """A lying capsule."""
    return limb((-0.6, 0.0, 0.15), (0.6, 0.0, 0.15), 0.15)


def mushroom() -> Any:
    """A stem under a disc."""
    cap = at(creation.cylinder(0.4, 0.15), (0.0, 0.0, 0.62))
    return joined(at(creation.cylinder(0.14, 0.6), (0.0, 0.0, 0.3)), cap)


def chair() -> Any:
    """A seat with a back on four thin legs."""
    legs = [(x, y, 0.22) for x in (-0.2, 0.2) for y in (-0.2, 0.2)]
    return joined(
        at(creation.box((0.5, 0.5, 0.1)), (0.0, 0.0, 0.45)),
        at(creation.box((0.1, 0.5, 0.6)), (-0.2, 0.0, 0.75)),
        *(at(creation.box((0.1, 0.1, 0.44)), place) for place in legs),
    )


def torus() -> Any:
    """A ring that stands on its rim."""
    ring = creation.torus(0.35, 0.15)
    turn: Any = trimesh.transformations.rotation_matrix  # its types are not told
    ring.apply_transform(turn(np.pi / 2.0, [1.0, 0.0, 0.0]))
    return ring


def biped() -> Any:
    """A trunk with a head and two arms, on two legs with feet."""
    sides = (-1.0, 1.0)
    return joined(
        limb((0.0, 0.0, 0.55), (0.0, 0.0, 0.95), 0.14),
        limb((0.0, 0.0, 1.0), (0.0, 0.0, 1.2), 0.08),
        at(creation.icosphere(subdivisions=3, radius=0.15), (0.0, 0.0, 1.2)),
        *(limb((0.0, 0.1 * side, 0.5), (0.0, 0.14 * side, 0.1), 0.085) for side in sides),
        *(at(creation.box((0.28, 0.16, 0.08)), (0.04, 0.14 * side, 0.04)) for side in sides),
        *(limb((0.0, 0.14 * side, 0.9), (0.0, 0.42 * side, 0.65), 0.06) for side in sides),
    )


BODIES: dict[str, Callable[[], Any]] = {
    make.__name__: make
    for make in (
        capsule,
        letter_y,
        table,
        starfish,
        quadruped,
        caterpillar,
        mushroom,
        chair,
        torus,
        biped,
    )
}
"""By name."""
