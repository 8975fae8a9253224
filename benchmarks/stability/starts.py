"""States that the suite's bodies are released from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from warp_softbody import Character
from warp_softbody.arrays import FloatArray


@dataclass(frozen=True, kw_only=True)
class Start:
    """Where a run begins.

    Attributes:
        positions: (n, 3) m.
        velocities: (n, 3) m/s.
    """

    positions: FloatArray
    velocities: FloatArray


Begin = Callable[[Character], Start]
"""What makes a start for a body."""


def _released(character: Character, positions: FloatArray) -> Start:
    """Standing still, with the clamped nodes where they belong."""
    placed = np.array(positions)
    placed[character.fixed] = character.mesh.points[character.fixed]
    return Start(positions=placed, velocities=np.zeros_like(placed))


def _held_point(character: Character) -> FloatArray:
    """Middle of the clamped face, or of a free body."""
    points = character.mesh.points
    return np.asarray(points[character.fixed if len(character.fixed) else slice(None)].mean(axis=0))


def at_rest(character: Character) -> Start:
    """The rest shape."""
    return _released(character, character.mesh.points)


def stretched(factor: float) -> Begin:
    """Stretched along x."""

    def begin(character: Character) -> Start:
        held = _held_point(character)
        return _released(character, held + (character.mesh.points - held) * [factor, 1.0, 1.0])

    return begin


def bent(character: Character) -> Start:
    """Stretched by 1.3 along x, the end lifted by a third of the length."""
    along = character.mesh.points[:, 0] - character.mesh.bounds[0, 0]
    positions = stretched(1.3)(character).positions
    positions[:, 2] += along**2 / (3.0 * along.max())
    return _released(character, positions)


def flattened(axis: int) -> Begin:
    """Every free node in the plane through the held point across an axis."""

    def begin(character: Character) -> Start:
        positions = character.mesh.points.copy()
        positions[:, axis] = _held_point(character)[axis]
        return _released(character, positions)

    return begin


def collapsed(character: Character) -> Start:
    """Every free node at the held point."""
    points = character.mesh.points
    return _released(character, np.broadcast_to(_held_point(character), points.shape))


def mirrored(axis: int) -> Begin:
    """Every free node mirrored in the plane through the held point across an axis."""

    def begin(character: Character) -> Start:
        positions = character.mesh.points.copy()
        positions[:, axis] = 2.0 * _held_point(character)[axis] - positions[:, axis]
        return _released(character, positions)

    return begin


def kinked(axis: tuple[float, float, float]) -> Begin:
    """All beyond one layer of cells in the middle turned by half a turn about a point of it."""

    def begin(character: Character) -> Start:
        positions = character.mesh.points.copy()
        planes = np.unique(positions[:, 0].round(9))
        cut = float(planes[len(planes) // 2 :][:2].mean())
        middle = np.array([cut, *character.mesh.bounds.mean(axis=0)[1:]])
        half_turn = Rotation.from_rotvec(np.pi * np.array(axis) / np.linalg.norm(axis))
        beyond = positions[:, 0] > cut
        positions[beyond] = middle + half_turn.apply(positions[beyond] - middle)
        return _released(character, positions)

    return begin


def turned(begin: Begin, seed: int) -> Begin:
    """Another start with the body turned at random, which matters to nothing but rounding."""

    def turn(character: Character) -> Start:
        start = begin(character)
        rotation = Rotation.random(random_state=seed).as_matrix()
        return Start(
            positions=start.positions @ rotation.T, velocities=start.velocities @ rotation.T
        )

    return turn


def scattered(seed: int) -> Begin:
    """Every free node anywhere in a box of ten times the body's box, about its middle."""

    def begin(character: Character) -> Start:
        low, high = character.mesh.bounds
        shares = np.random.default_rng(seed).uniform(-5.0, 5.0, character.mesh.points.shape)
        return _released(character, 0.5 * (low + high) + shares * (high - low))

    return begin


def spinning(speed: float) -> Begin:
    """The rest shape turning about a skew axis through its middle by ``speed`` rad/s."""

    def begin(character: Character) -> Start:
        points = character.mesh.points
        arms = points - points.mean(axis=0)
        axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
        return Start(positions=points.copy(), velocities=np.cross(speed * axis, arms))

    return begin
