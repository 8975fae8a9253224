"""Single precision where its rounding is small beside what a step changes, double elsewhere.

Positions are rounded to eps times the distance from the origin. That is a strain of so much over
the shortest edge, hence a pressure; and what the next step makes good of it is a velocity. The
matrix of a step is rounded to eps times its stiffness, beside which the mass must not be lost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from warp_softbody.arrays import FloatArray
from warp_softbody.body.character import Character
from warp_softbody.body.material import Material
from warp_softbody.body.mesh_geometry import shortest_edge
from warp_softbody.engine.options import SimulationOptions
from warp_softbody.world.scene import Scene

EPS = float(np.finfo(np.float32).eps) / 2.0
"""Relative rounding of single precision."""


MOST_OF_MASS = 0.05
"""Rounding of the matrix, of the mass in it."""

MOST_PRESSURE = 0.05
"""Pressure that rounding may make, of that of a body's weight."""

MOST_SPEED = 1e-3
"""Speed that rounding may make in a step, of what gravity does in it, or of ``SLOW`` motion."""

SLOW = 1e-2
"""Of a body's initial speed."""

SECONDS = 1.0
"""How far ahead, s, a body's initial velocity counts as a distance."""


def with_precision(options: SimulationOptions, scene: Scene) -> SimulationOptions:
    """The options with "auto" replaced by the precision that suits a scene."""
    if options.precision != "auto":
        return options
    return replace(options, precision=choose_precision(scene, options.time_step))


def choose_precision(scene: Scene, time_step: float) -> Literal["float32", "float64"]:
    """The cheapest precision whose rounding hides nothing in a scene at a time step, s."""
    reaches = []
    for character, (velocity, _) in zip(scene.characters, scene.starts, strict=True):
        away = float(np.abs(character.mesh.points).max())
        reaches.append(away + SECONDS * float(np.linalg.norm(velocity)))
    return "float32" if lost_in_single(scene, reaches, time_step) is None else "float64"


def lost_in_single(scene: Scene, reaches: Sequence[float], time_step: float) -> str | None:
    """What rounding to single precision hides in a scene; None where it hides nothing.

    Args:
        scene: its bodies, gravity and contacts.
        reaches: how far from the origin each body comes, m.
        time_step: s.
    """
    touches = scene.ground is not None or scene.has_pairs
    speeds = [velocity for velocity, _ in scene.starts]
    gravity = np.asarray(scene.gravity, dtype=float)
    for character, reach, velocity in zip(scene.characters, reaches, speeds, strict=True):
        edge = shortest_edge(character.mesh.points, character.mesh.tets)
        body = _Body(character, edge, reach)
        lost = None
        if body.stiffness_over_mass(time_step) * EPS > MOST_OF_MASS:
            lost = "the mass beside the stiffness"
        elif touches and body.false_pressure > MOST_PRESSURE * body.weight(gravity):
            lost = "the pressure of the weight"
        elif body.false_speed(time_step) > MOST_SPEED * usual_change(gravity, velocity, time_step):
            lost = "what a step adds to the velocities"
        if lost is not None:
            return f"{lost} of body {character.name!r}"
    return None


def stiffness_over_mass(material: Material, edge: float, dt: float) -> float:
    """Ratio of the stiffness in M~ to the mass at a node with edges as short as ``edge``, m."""
    stiff = material.young_modulus * (dt * material.stiffness_damping + dt * dt)
    return stiff / (material.density * edge**2)


def hardest_material(character: Character) -> Material:
    """The stiffest of the materials that a body has."""
    return max(
        (character.material, *character.materials.values()), key=lambda each: each.young_modulus
    )


def usual_change(gravity: FloatArray, velocity: ArrayLike, time_step: float) -> float:
    """What a step adds to a body's velocity, m/s; without gravity and speed, no bound."""
    fall = float(np.linalg.norm(gravity)) * time_step
    return max(fall, SLOW * float(np.linalg.norm(velocity))) or np.inf


@dataclass(frozen=True)
class _Body:
    """A body as far from the origin as ``reach``, m; its shortest ``edge``, m."""

    character: Character
    edge: float
    reach: float

    def stiffness_over_mass(self, dt: float) -> float:
        """See the function of this name."""
        return stiffness_over_mass(hardest_material(self.character), self.edge, dt)

    @property
    def false_pressure(self) -> float:
        """Pa, of the strain that rounding of positions is."""
        return hardest_material(self.character).young_modulus * EPS * self.reach / self.edge

    def weight(self, gravity: FloatArray) -> float:
        """Pa under a column as high as the body; without gravity, no bound."""
        strength = float(np.linalg.norm(gravity))
        if strength == 0.0:
            return np.inf
        height = float(np.ptp(self.character.mesh.points @ (gravity / strength)))
        return self.character.material.density * strength * height

    def false_speed(self, dt: float) -> float:
        """m/s at which a step makes good of the rounding of positions."""
        return EPS * self.reach / (dt + self.character.material.stiffness_damping)
