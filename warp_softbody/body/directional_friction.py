"""The friction of a region may depend on its direction of sliding, like that of scales."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warp_softbody.arrays import FloatArray
from warp_softbody.errors import InputError
from warp_softbody.inputs import array_checks, checks, input_kinds

DIRECTIONS = 8
"""Directions for which the engine keeps a factor, evenly spread around the normal."""


@dataclass(frozen=True, kw_only=True)
class DirectionalFriction:
    """Factors on the ground's friction for a region of a body (docs/contact.md).

    Attributes:
        region: name of the region of the character.
        direction: forward in the rest shape; turned with the body while it moves.
        factors: of the friction that a node meets while it slides in directions evenly spread over
            a turn, the first forward, counter-clockwise seen from above the ground: 4 (forward,
            left, backward, right) or 8 numbers; linear in the angle between them.
    """

    region: str
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    factors: tuple[float, ...] = (1.0, 1.0, 10.0, 1.0)

    def __post_init__(self) -> None:
        """Normalise the direction and refuse factors that are not positive."""
        input_kinds.name("DirectionalFriction.region", self.region)
        x, y, z = checks.direction("DirectionalFriction.direction", self.direction)
        label = f"DirectionalFriction.factors of {self.region!r}"
        factors = array_checks.array(label, self.factors, (None,)).tolist()
        if len(factors) not in (4, DIRECTIONS):
            raise InputError(f"{label} takes 4 or {DIRECTIONS} factors, got {len(factors)}")
        if min(factors) <= 0.0:
            raise InputError(f"{label} must be finite and positive, not {checks.shown(factors)}")
        checks.keep(self, direction=(x, y, z), factors=tuple(factors))

    @property
    def eight(self) -> FloatArray:
        """Return the factors of eight directions (8,); between four given ones the means."""
        given = np.array(self.factors)
        if len(given) == DIRECTIONS:
            return given
        return np.stack([given, 0.5 * (given + np.roll(given, -1))], axis=1).ravel()


def factors_at(eight: FloatArray, angles: FloatArray) -> FloatArray:
    """Factors at angles (..., k) from forward, rad, linear between the eight given (..., 8)."""
    place = np.mod(angles, 2.0 * np.pi) * DIRECTIONS / (2.0 * np.pi)
    low = place.astype(np.int64)
    rows = np.arange(eight.size // DIRECTIONS).reshape(*eight.shape[:-1], 1)
    flat = eight.reshape(-1, DIRECTIONS)
    first, second = flat[rows, low % DIRECTIONS], flat[rows, (low + 1) % DIRECTIONS]
    return np.asarray(first + (place - low) * (second - first))


class NodeFriction(NamedTuple):
    """Forward directions at rest (n, 3) and factors (n, 8) of all nodes."""

    forward: FloatArray
    factors: FloatArray


def friction_by_node(
    frictions: Iterable[DirectionalFriction],
    regions: Mapping[str, npt.NDArray[np.int32]],
    count: int,
) -> NodeFriction:
    """What the regions say of each node, the last that holds it; factors of one for the others.

    Args:
        frictions: those of a body.
        regions: the body's nodes by region.
        count: number of the body's nodes.
    """
    forward = np.tile([1.0, 0.0, 0.0], (count, 1))
    factors = np.ones((count, DIRECTIONS))
    for friction in frictions:
        nodes = regions[friction.region]
        forward[nodes] = friction.direction
        factors[nodes] = friction.eight
    return NodeFriction(forward, factors)
