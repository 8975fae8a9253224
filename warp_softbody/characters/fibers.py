"""The fibres of the shipped characters share these shapes and this strength."""

from __future__ import annotations

import numpy as np

from warp_softbody.body.material import Material
from warp_softbody.body.muscles import Fiber, FiberKind, MuscleGroup

STRENGTH = 0.8
"""E, of upright letters."""

STRENGTH_TO_BEND = 1.6
"""E, of letters that lift parts of themselves by bending."""

KERNEL_WIDTH = 0.12
"""m, of every group but those whose fibres lie closer together than this."""

QUADRANTS = ((-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0))
"""Signs of the first and second coordinate, in the order of all regions and fibres in fours."""


def group(
    name: str, *fibers: Fiber, strength: float = STRENGTH, kernel_width: float = KERNEL_WIDTH
) -> MuscleGroup:
    """Fibres of one kind that share the tets between them; their strength in E of the letters."""
    strength *= Material().young_modulus
    return MuscleGroup(fibers=fibers, strength=strength, kernel_width=kernel_width, name=name)


def upright(name: str, x: float, y: float, ends: tuple[float, float], segments: int) -> Fiber:
    """A longitudinal fibre along z between two heights, m."""
    heights = np.linspace(*ends, segments + 1)
    vertices = np.stack([np.full_like(heights, x), np.full_like(heights, y), heights], axis=1)
    return Fiber(vertices=vertices, kind=FiberKind.LONGITUDINAL, name=name)


def four_upright(
    offset: tuple[float, float], ends: tuple[float, float], segments: int, middle: float = 0.0
) -> MuscleGroup:
    """Fibres `longitudinal_0` to `longitudinal_3` at offsets (+-x, +-y), m, from x = middle."""
    x, y = offset
    return group(
        "longitudinal",
        *(
            upright(f"longitudinal_{i}", middle + side_x * x, side_y * y, ends, segments)
            for i, (side_x, side_y) in enumerate(QUADRANTS)
        ),
    )


def ring(
    name: str,
    center: tuple[float, float, float],
    first: tuple[float, float, float],
    second: tuple[float, float, float],
    segments: int,
) -> Fiber:
    """A radial fibre: a closed ellipse from center + first towards center + second, m."""
    angles = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    vertices = np.array(center) + np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second)
    return Fiber(vertices=vertices, kind=FiberKind.RADIAL, name=name)


def helix(
    name: str, radius: float, start: float, turns: float, ends: tuple[float, float], segments: int
) -> Fiber:
    """A helical fibre around the z axis from an angle (rad), right-handed for positive turns."""
    angles = start + np.linspace(0.0, 2.0 * np.pi * turns, segments + 1)
    heights = np.linspace(*ends, segments + 1)
    vertices = np.stack([radius * np.cos(angles), radius * np.sin(angles), heights], axis=1)
    return Fiber(vertices=vertices, kind=FiberKind.HELICAL, name=name)
