"""Bodies that a controller was to keep upright, and that lie at the end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from warp_softbody.arrays import FloatArray
from warp_softbody.engine.model import Model

STANDS = np.radians(30.0)
"""Tilt (rad) up to which a body stands."""

LIES = np.radians(60.0)
"""Tilt (rad) from which on it has fallen: no walk or jump leans as far and comes back."""

SUNK = 0.1
"""Share by which the height of its centre of mass has changed then: a round body that lies and
rolls about its own axis keeps it."""


def tilt(rest: FloatArray, now: FloatArray, masses: FloatArray) -> float:
    """Angle (rad) of a body's own z axis from z, 0 to pi.

    Args:
        rest: (n, 3) m, its nodes at rest.
        now: (n, 3) m, its nodes.
        masses: (n,) kg, which weigh the fit of the rotation (Kabsch 1976).
    """
    arms = masses[:, None] * (rest - masses @ rest / masses.sum())
    left, _, right = np.linalg.svd((now - masses @ now / masses.sum()).T @ arms)
    hand = np.array([1.0, 1.0, np.linalg.det(left @ right)])
    return float(np.arccos(np.clip((left * hand @ right)[2, 2], -1.0, 1.0)))


@dataclass(frozen=True)
class _Standing:
    """A body, whether it stood when the run began, and how high (m) its centre of mass was."""

    number: int
    stood: bool
    height: float


class Falls:
    """Compares the first and the last tilt of bodies that controllers are to keep upright.

    A controller that turns its body over, as in a somersault, does not say so while it does.
    """

    def __init__(self, model: Model, names: Sequence[str], positions: FloatArray) -> None:
        """Watch the bodies of these names, with nodes at ``positions`` (n, 3), m, at the start."""
        self._model = model
        parts = model.scene.parts
        self._watched = [
            _Standing(
                number, self._tilt(number, positions) < STANDS, self._height(number, positions)
            )
            for number, part in enumerate(parts)
            if part.name in names
        ]

    def doubts(self, positions: FloatArray, names: Sequence[str]) -> Iterator[str]:
        """A sentence about each that stood and lies with nodes at ``positions`` (n, 3), m.

        ``names`` are of the bodies that are to be upright now.
        """
        if not np.isfinite(positions).all():
            return
        for body in self._watched:
            name = self._model.scene.parts[body.number].name
            if name not in names:
                continue
            leans = self._tilt(body.number, positions)
            moved = abs(self._height(body.number, positions) - body.height)
            if body.stood and leans > LIES and moved > SUNK * body.height:
                yield (
                    f"body {name!r} fell: it stood at the start and ends tilted by "
                    f"{np.degrees(leans):.0f} degrees, which its controller was to prevent; take a "
                    "weaker push, a slower motion or a wider base"
                )

    def _height(self, number: int, positions: FloatArray) -> float:
        """Of the centre of mass over the lowest node, m."""
        nodes = self._model.scene.parts[number].nodes
        masses, heights = self._model.masses[nodes], positions[nodes, 2]
        return float(masses @ heights / masses.sum() - heights.min())

    def _tilt(self, number: int, positions: FloatArray) -> float:
        scene = self._model.scene
        rest, nodes = scene.characters[number].mesh.points, scene.parts[number].nodes
        return tilt(rest, positions[nodes], self._model.masses[nodes])
